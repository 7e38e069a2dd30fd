"""Bounds on what any policy can achieve: dynamic programming and trajectory search."""
