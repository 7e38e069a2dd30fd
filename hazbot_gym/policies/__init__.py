"""Speed policies: maps from observations to the robot's speed.

- ``base``: the policy protocol, construction by name, and the register
- ``own_module``: user-defined policies, by ``module:attribute``
- ``guard``: stop on invalid observations, for all policies
- ``constant``: constant speed
- ``stop_on_sight``, ``stop_when_near``: stop for obstacles ahead, or for near people
- ``sonar_estimate``: people from ultrasonic readings; ``people_rule``: base class of rules on it
- ``people_seen``: positions and velocities of people; ``robot``: the robot's limits
- ``ssm``, ``passive_safety``: speed limits by clearance, from a standard or a proof
- ``ttc``, ``velocity_obstacle``: the largest speed without an imminent collision
- ``hall_steps``, ``idm``: speeds by Hall's zones; car following
- ``mpc``: optimal plan for people at constant velocity, computed in ``mpc_plan``
- ``social_force``: speed by the total social force
- ``fuzzy_expert``: the paper's fuzzy strategy, the reference; ``fuzzy_readings``: other readings of
  the paper; ``fuzzy_system``: the same in scikit-fuzzy; ``person_columns``: columns for kernels
- ``learned``: trained policies, from files; ``actor`` computes them with ``layer`` and ``lstm``,
  ``actor_file`` stores them, ``residual`` adds them to a rule
- ``made_for``: the nominal speed and decision period that a policy is made for
- ``shielded``: any policy, at most as fast as a rule permits
- ``sweeps``: the sweep parameter of each family; ``tuning_spaces``: tuning spaces
"""

from hazbot_gym.policies.base import Permissions, Policy, make, names

__all__ = ["Permissions", "Policy", "make", "names"]
