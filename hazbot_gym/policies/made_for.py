"""The nominal speed and the decision period that a policy is made for.

A trained policy is made for those of its training, a rule with an option ``nominal_mps`` for that
speed. An observation tells neither.
"""

from __future__ import annotations

from collections.abc import Iterator

from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.gas_rule import GasRule
from hazbot_gym.policies.guard import Guarded
from hazbot_gym.policies.learned import FromFile, TrainedActor
from hazbot_gym.policies.residual import Residual
from hazbot_gym.policies.shielded import Shielded
from hazbot_gym.task.observation import Layout
from hazbot_gym.utils.json_object import JsonObject

SPEED, PERIOD = "drive.nominal_speed_mps", "clock.decision_s"  # names of the config


def parts_of(policy: Policy, layout: Layout) -> Iterator[Policy]:
    """Yield a policy without parts, or the parts of one that is put together of others.

    Args:
        policy: The policy.
        layout: Layout of its observations, which chooses the shipped policy.
    """
    if isinstance(policy, FromFile):
        yield from parts_of(policy.policy_for(layout), layout)
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
    """Return the values of the config that a part is made for, by dotted name, if it tells."""
    trained = training_config(part)
    if trained is not None:
        return {
            SPEED: trained["drive"]["nominal_speed_mps"],
            PERIOD: trained["clock"]["decision_s"],
        }
    nominal_mps = getattr(part, "nominal_mps", None) if isinstance(part, Guarded) else None
    return {} if nominal_mps is None else {SPEED: float(nominal_mps)}
