"""A rule with a learned correction on top of it.

    action = clip(base(o) + scale * network(o), -1, 1)

Residual policy learning (Silver, Allen, Tenenbaum and Kaelbling 2018; Johannink et al., ICRA 2019):
what the rule knows need not be learned again, and a network that answers 0 is the rule itself. The
network's answer is clipped to [-1, 1] first, so the rule is overruled by ``scale`` at most.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import REGISTER, Policy, make
from hazbot_gym.policies.guard import Actions, Flags, Guarded, Observations


def corrected(action: Actions, correction: Actions, scale: float) -> Actions:
    """Return the base's actions (N, 1) with corrections (N, 1), both in [-1, 1]."""
    total: Actions = np.clip(action + np.float32(scale) * correction, -1.0, 1.0)
    return total


def base_of(spec: str) -> Policy:
    """Return the policy that a correction goes on top of.

    A file of weights names it, and reading one must run nothing that is in it. So neither modules
    nor other files are followed.

    Raises:
        InvalidInput: It is no rule of the library, or its options are not allowed.
    """
    allowed = [name for name in REGISTER if name != "learned"]
    if spec.partition(":")[0] not in allowed:
        raise InvalidInput(f"residual.base: given {spec!r}, allowed are {', '.join(allowed)}")
    return make(spec)


def unguarded(
    policy: Policy, observation: Observations, state: Any, starts: Flags | None, deterministic: bool
) -> tuple[Actions, Any]:
    """Return a part's bare answer: a stop of one part alone would not stop the whole."""
    answer = policy.act if isinstance(policy, Guarded) else policy.predict
    return answer(observation, state, starts, deterministic)


def on_its_base(network: Policy, residual: Mapping[str, Any] | None) -> Policy:
    """Return a network as it drives: on its base, or alone where there is none."""
    if residual is None:
        return network
    return Residual(base_of(residual["base"]), network, residual["scale"])


class Residual(Guarded):
    """A base and a network as one policy; the inner state is that of the one and of the other."""

    def __init__(self, base: Policy, network: Policy, scale: float) -> None:
        self.base, self.network, self.scale = base, network, scale

    def act(
        self, observation: Observations, state: Any, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, Any]:
        """Return the corrected action and the next states of both; see ``Guarded.act``."""
        rule, memory = (None, None) if state is None else state
        action, rule = unguarded(self.base, observation, rule, starts, deterministic)
        correction, memory = unguarded(self.network, observation, memory, starts, deterministic)
        return corrected(action, correction, self.scale), (rule, memory)
