"""Intervals, tests and aggregates over episodes, scenarios and training seeds."""
