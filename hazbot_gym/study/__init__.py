"""The study: run policies over scenarios, measure every episode, compare with honest intervals.

Read in this order: ``metrics`` (one episode to one row), ``statistics`` (intervals), ``rollout``
(one policy in one environment), ``config`` (what a study consists of), ``records`` (files that are
never half-written), ``summary`` and ``tables`` (rows to results), ``comparison`` (the main job).
"""
