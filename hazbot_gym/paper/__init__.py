"""The published paper, run again: every experiment on this library's environment and controllers.

Experiments are modules of this package and know nothing of pictures; ``figures`` draws what they
found, ``chapters`` says it in the order of the paper's sections, and ``run`` makes ``paper.json``
and the page of them.
"""
