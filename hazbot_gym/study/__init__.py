"""The study: compare policies over the same scenarios, with intervals.

Read in this order: ``config`` (what a study consists of), ``run`` (the main job), ``candidates``
(policies that are tuned or trained first), ``store`` (the files of a study), ``summary`` (rows to
results), ``terminal_tables`` and ``report`` (results to look at). ``scenario_bank`` holds the
frozen scenarios.
"""
