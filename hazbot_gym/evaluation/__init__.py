"""Evaluation: run a policy, record its episodes from the true state, and measure them.

Read in this order: ``episode`` (what is recorded), ``metrics`` (an episode to a row of numbers),
``driver`` (a policy in an environment), ``rollout`` and ``batch_rollout`` (its episodes, on either
engine), ``scenario_set`` (named families of scenarios). ``statistics`` holds intervals and tests,
``oracle`` bounds on what any policy can achieve.
"""
