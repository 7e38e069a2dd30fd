"""Speed policies: what the robot does with its speed, from observations alone.

- ``base``: what a policy is, how one is made from its name, and their register
- ``own_module``: policies of the user, by ``module:attribute``
- ``guard``: stop where an observation is invalid, for all of them
- ``constant``: one speed, whatever happens
- ``stop_on_sight``, ``stop_when_near``: stop for what is ahead, or for whoever is near
- ``sonar_estimate``: people from ultrasonic readings; ``people_rule``: rules that see them so
- ``people_seen``: where people are and how they walk; ``robot``: the limits that rules count on
- ``ssm``, ``passive_safety``: so slow that the robot stands in time, by a standard or by a proof
- ``ttc``, ``velocity_obstacle``: the largest speed that meets nobody soon
- ``hall_steps``, ``idm``: speeds of Hall's zones; following whoever is ahead, like a car
- ``mpc``: the best plan if people walk straight on, worked out in ``mpc_plan``
- ``social_force``: speed by the total social force
- ``fuzzy_expert``: the paper's fuzzy strategy, the reference; ``fuzzy_readings``: the paper read
  otherwise; ``fuzzy_system``: the same in scikit-fuzzy; ``person_columns``: what kernels read
- ``learned``: trained ones, from files; ``actor`` computes them of ``layer`` and ``lstm``,
  ``actor_file`` keeps them, ``residual`` puts them on top of a rule
- ``knobs``: the one knob of each family, and sweeps over it; ``search_spaces``: what may be tuned
"""

from hazbot_gym.policies.base import Permissions, Policy, make, names

__all__ = ["Permissions", "Policy", "make", "names"]
