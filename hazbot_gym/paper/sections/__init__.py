"""Sections of the paper: an experiment, its plots, and the section of the report."""
