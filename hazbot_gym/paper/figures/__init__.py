"""Figures of the results as SVG, one module per section of the paper."""
