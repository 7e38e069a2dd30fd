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
import numpy.typing as npt

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import REGISTER, Actions, Observations, Policy, make


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


def on_its_base(network: Policy, residual: Mapping[str, Any] | None) -> Policy:
    """Return a network as it drives: on its base, or alone where there is none."""
    if residual is None:
        return network
    return Residual(base_of(residual["base"]), network, residual["scale"])


class Residual:
    """A base and a network as one policy; the inner state is that of the one and of the other."""

    def __init__(self, base: Policy, network: Policy, scale: float) -> None:
        self.base, self.network, self.scale = base, network, scale

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Any]:
        """Return the corrected action and the next states of both; see ``Policy.predict``."""
        rule, memory = (None, None) if state is None else state
        action, rule = self.base.predict(observation, rule, episode_start, deterministic)
        correction, memory = self.network.predict(observation, memory, episode_start, deterministic)
        return corrected(action, correction, self.scale), (rule, memory)
