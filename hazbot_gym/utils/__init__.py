"""Helpers without a subject of their own, which every room but ``core`` may use."""
