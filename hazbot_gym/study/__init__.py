"""The study: compare policies over the same scenarios, with intervals.

Read in this order: ``config`` (definition of a study), ``run`` (the main job), ``candidates``
(policies that are tuned or trained first), ``store`` (the files of a study), ``summary`` (rows to
results), ``terminal_tables`` and ``report`` (presentation). ``scenario_bank`` holds the frozen
scenarios.
"""
