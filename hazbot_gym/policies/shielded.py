"""Shield: any policy, at most as fast as a rule about people permits.

    v = min(v of the policy, v that the rule permits)

A shield needs no training (compare runtime assurance, Hobbs et al. 2023). By default the rule is
passive safety for people who walk at 1.6 m/s, the speed that ISO 13855 assumes: the robot has
stopped before any of them can reach it (``passive_safety``). The bound holds for people who are
tracked, and for their tracked distances.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from pydantic.dataclasses import dataclass

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import OPTIONS, Policy, make
from hazbot_gym.policies.guard import Actions, Flags, Guarded, Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.residual import unguarded


@dataclass(frozen=True, config=OPTIONS)
class Shielded(Guarded):
    """A policy with a shield. The state is a pair: of the policy and of the rule."""

    policy: str  # spec of the policy
    by: str = "passive_safety:obstacle_mps=1.6"  # spec of the rule
    allow_pickle: bool = False  # of the policy; see ``base.make``
    allow_code: bool = True

    def __post_init__(self) -> None:
        if not isinstance(self.rule, PeopleRule):
            raise InvalidInput(
                f"by: given {self.by!r}, allowed are rules about people, such as passive_safety"
            )
        self.policy_inside  # noqa: B018  (a policy that cannot be made is refused here)

    def act(
        self, observation: Observations, state: Any, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, object]:
        """Return the slower of both actions, and both states; see ``Guarded.act``."""
        own, its = (None, None) if state is None else state
        wanted, own = unguarded(self.policy_inside, observation, own, starts, deterministic)
        permitted, its = unguarded(self.rule, observation, its, starts, deterministic)
        return np.minimum(wanted, permitted), (own, its)

    @cached_property
    def policy_inside(self) -> Policy:
        """Return the policy that is shielded."""
        return make(self.policy, allow_pickle=self.allow_pickle, allow_code=self.allow_code)

    @cached_property
    def rule(self) -> Policy:
        """Return the rule that limits its speed."""
        return make(self.by, allow_code=False)
