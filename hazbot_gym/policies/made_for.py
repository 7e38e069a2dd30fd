"""The robot that a policy is made for, and the refusal of environments with another one.

A trained policy is made for the nominal speed and the decision period of its training, a rule with
an option ``nominal_mps`` for that speed. An observation tells neither.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.config.randomised import value_at
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.gas_rule import GasRule
from hazbot_gym.policies.guard import Guarded
from hazbot_gym.policies.learned import FromFile, TrainedActor
from hazbot_gym.policies.residual import Residual
from hazbot_gym.policies.shielded import Shielded
from hazbot_gym.task.observation import Layout, layout_in
from hazbot_gym.utils.json_object import JsonObject

SPEED, PERIOD = "drive.nominal_speed_mps", "clock.decision_s"
SAME = 1e-6  # tolerance of speeds and times


def parts_of(policy: Policy, layout: Layout) -> Iterator[Policy]:
    """Yield a policy without parts, or the parts of one that is put together of others.

    Args:
        policy: The policy.
        layout: Layout of its observations, which chooses the shipped policy.
    """
    if isinstance(policy, FromFile):
        yield from parts_of(policy.policy_for(np.zeros(layout.width, np.float32)), layout)
    elif isinstance(policy, Residual):
        yield from parts_of(policy.network, layout)
        yield from parts_of(policy.base, layout)
    elif isinstance(policy, Shielded):
        yield from parts_of(policy.policy_inside, layout)
        yield from parts_of(policy.rule, layout)
    elif isinstance(policy, GasRule) and policy.people_rule is not None:
        yield policy.people_rule
    else:
        yield policy


def training_config(policy: Policy) -> JsonObject | None:
    """Return the config of a trained policy's environments; None if it is not known."""
    if not isinstance(policy, TrainedActor):
        return None
    environments = policy.about.get("training", {}).get("environments", {})
    return next(iter(environments.values()), None)  # a training has one robot in all of them


def needs_of(part: Policy) -> dict[str, float]:
    """Return the nominal speed and the decision period that a part is made for, if it tells."""
    trained = training_config(part)
    if trained is not None:
        return {name: value_at(trained, name) for name in (SPEED, PERIOD)}
    nominal_mps = getattr(part, "nominal_mps", None) if isinstance(part, Guarded) else None
    return {} if nominal_mps is None else {SPEED: float(nominal_mps)}


def check_made_for(policy: Policy, config: Config, name: str = "") -> None:
    """Refuse a policy that is made for another nominal speed or decision period.

    Args:
        policy: The policy.
        config: Config of the environment.
        name: Name of the policy for the message; default its class.

    Raises:
        InvalidInput: The first difference; one line.
    """
    for part in parts_of(policy, layout_in(config)):
        for field, needed in needs_of(part).items():
            given = value_at(config, field)
            if not abs(given - needed) <= SAME:
                is_rule = part is policy and not isinstance(part, TrainedActor)
                remedy = f"; give its option nominal_mps={given:g}" if is_rule else ""
                raise InvalidInput(
                    f"{field}: given {given:g}, but {name or type(policy).__name__} is made for "
                    f"{needed:g}{remedy}"
                )
