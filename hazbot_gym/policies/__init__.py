"""Speed policies: what the robot does with its speed, from observations alone.

- ``base``: what a policy is, how one is made from its name, and their register
- ``constant``: one speed, whatever happens
- ``fuzzy_expert``: the paper's fuzzy strategy, the reference
- ``learned``: trained ones, from files; ``actor`` computes them, ``actor_file`` keeps them
"""

from hazbot_gym.policies.base import Policy, make, names

__all__ = ["Policy", "make", "names"]
