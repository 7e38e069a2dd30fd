"""Reproduction of the published paper: every experiment with this library.

``sections`` has a folder for each section of the paper: ``experiment`` computes, ``plots`` draws,
``section`` reports. ``numbers`` lists the values that the paper reports, and ``run`` writes
``paper.json`` and the page.
"""
