"""The study: run policies over scenarios, measure every episode, compare with honest intervals.

Read in this order: ``episode`` and ``metrics`` (one episode to one row), ``statistics``
(intervals; for several training seeds ``crossed_bootstrap`` and the files that import it),
``rollout`` and ``batch_rollout`` (one policy in one environment, on either engine), ``config``
(what a study consists of), ``records`` (files that are never half-written), ``summary`` and
``tables`` (rows to results), ``comparison`` (the main job), ``report`` (the page of a study).
``bench`` measures speed.
"""
