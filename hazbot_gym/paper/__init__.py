"""Reproduction of the published paper: every experiment with this library.

Experiments are modules of this package, independent of figures; ``figures`` draws their results,
``chapters`` reports them in the order of the paper's sections, and ``run`` writes ``paper.json``
and the page.
"""
