"""Residual policy: a rule with a learned correction.

    action = clip(base(o) + scale * network(o), -1, 1)

Residual policy learning (Silver, Allen, Tenenbaum and Kaelbling 2018; Johannink et al., ICRA 2019):
the network only learns a correction, and a zero network equals the rule. The network's output is
clipped to [-1, 1], so that the correction is at most ``scale``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import REGISTER, Policy, make
from hazbot_gym.policies.guard import Actions, Flags, Guarded, Observations
from hazbot_gym.utils.json_object import JsonObject


def corrected(action: Actions, correction: Actions, scale: float) -> Actions:
    """Return the base's actions (N, 1) with corrections (N, 1), both in [-1, 1]."""
    total: Actions = np.clip(action + np.float32(scale) * correction, -1.0, 1.0)
    return total


def base_of(spec: str) -> Policy:
    """Return the base policy of a residual.

    Its name comes from a weights file, and reading must not execute code. So neither modules nor
    other files are allowed.

    Raises:
        InvalidInput: The base is no rule of the library, or its options are not allowed.
    """
    allowed = [name for name in REGISTER if name not in ("learned", "shielded")]
    if spec.partition(":")[0] not in allowed:
        raise InvalidInput(f"residual.base: given {spec!r}, allowed are {', '.join(allowed)}")
    return make(spec)


def unguarded(
    policy: Policy,
    observation: Observations,
    state: object,
    starts: Flags | None,
    deterministic: bool,
) -> tuple[Actions, object]:
    """Return a part's action without its guard, since only the whole policy may stop."""
    answer = policy.act if isinstance(policy, Guarded) else policy.predict
    return answer(observation, state, starts, deterministic)


def on_its_base(network: Policy, residual: JsonObject | None) -> Policy:
    """Return a network with its base, or the network itself without a base."""
    if residual is None:
        return network
    return Residual(base_of(residual["base"]), network, residual["scale"])


class Residual(Guarded):
    """Residual policy of a base and a network; the state is a pair."""

    def __init__(self, base: Policy, network: Policy, scale: float) -> None:
        self.base, self.network, self.scale = base, network, scale

    def act(
        self, observation: Observations, state: Any, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, object]:
        """Return the corrected action and the pair of states; see ``Guarded.act``."""
        rule, memory = (None, None) if state is None else state
        action, rule = unguarded(self.base, observation, rule, starts, deterministic)
        correction, memory = unguarded(self.network, observation, memory, starts, deterministic)
        return corrected(action, correction, self.scale), (rule, memory)
