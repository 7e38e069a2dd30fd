"""Plan of an export: the parts of a policy that are computed elsewhere, or why it cannot be."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.base import Policy, make
from hazbot_gym.policies.constant import Constant
from hazbot_gym.policies.fuzzy_expert import FuzzyExpert
from hazbot_gym.policies.learned import FromFile, Learned, TrainedActor, trained_layout
from hazbot_gym.policies.residual import Residual
from hazbot_gym.policies.ssm import Ssm
from hazbot_gym.runtime.controller import robot_for
from hazbot_gym.task.observation import TIERS, Layout, layout_for, observing_layout

RULES = "constant, ssm:mode=strict and fuzzy_expert"
Rule = Constant | Ssm | FuzzyExpert


class Plan(NamedTuple):
    """A policy taken apart: a rule, a network, or a network that corrects a rule."""

    spec: str
    policy: Policy  # in Python, beside which exports are checked
    layout: Layout
    rule: Rule | None
    actor: Actor | None
    scale: float | None  # of the network's correction; None without a rule or without a network
    nominal_mps: float
    period_s: float

    @property
    def listens(self) -> bool:
        """True if the rule estimates people from echoes, which needs a memory of them."""
        return not self.layout.has_people and isinstance(self.rule, Ssm | FuzzyExpert)

    @property
    def has_memory(self) -> bool:
        """True if an answer depends on earlier observations."""
        return self.memory > 0 or self.listens

    @property
    def memory(self) -> int:
        """Number of entries of the LSTM's hidden state; 0 without an LSTM."""
        return self.actor.lstm.size if self.actor and self.actor.lstm else 0


def plan_of(spec: str, tier: str | None = None) -> Plan:
    """Return the plan of a policy.

    Args:
        spec: As of ``make_policy``.
        tier: Tier of the observations; default that of a trained policy, ``tracks`` for others.

    Raises:
        InvalidInput: The policy is unknown, or it has a part that cannot be exported; one line.
    """
    if tier is not None and tier not in TIERS:
        raise InvalidInput(f"tier: given {tier!r}, allowed are {', '.join(TIERS)}")
    if spec.startswith("learned:") and spec.endswith(".zip"):
        raise InvalidInput(
            f"policy: {spec!r} lacks the statistics of its observations; allowed is the .npz that "
            "training.export.export_model makes of the model"
        )
    policy = make(spec)
    layout = _layout(policy, tier)
    with observing_layout(layout):
        policy.predict(np.zeros(layout.width, np.float32))  # refuses another tier than the policy's
        chosen = policy.policy_for(layout) if isinstance(policy, FromFile) else policy
        robot = robot_for(policy, layout)
    base: Policy | None = chosen
    network: Policy | None = None
    scale: float | None = None
    if isinstance(chosen, Residual):
        base, network, scale = chosen.base, chosen.network, chosen.scale
    elif isinstance(chosen, TrainedActor):
        base, network = None, chosen
    if network is not None and not isinstance(network, TrainedActor):
        raise InvalidInput(f"policy: {spec!r} has a network that cannot be exported")
    rule = None if base is None else _rule(spec, base)
    actor = None if network is None else network.actor
    return Plan(
        spec, policy, layout, rule, actor, scale, robot.nominal_speed_mps, robot.decision_period_s
    )


def _layout(policy: Policy, tier: str | None) -> Layout:
    """Return the layout of a tier, or the one of a trained policy."""
    if isinstance(policy, Learned):
        own = trained_layout(policy.policy_for(layout_for(tier or "tracks")))
        if own and (tier is None or own.has_people == (tier != "sonar")):
            return own
    return layout_for(tier or "tracks")


def _rule(spec: str, base: Policy) -> Rule:
    """Return a rule that can be exported."""
    is_known = (
        type(base) is Constant
        or type(base) is FuzzyExpert
        or (type(base) is Ssm and base.mode == "strict")
    )
    if not is_known:
        raise InvalidInput(
            f"policy: {spec!r} cannot be exported; allowed are trained networks, the rules "
            f"{RULES}, and networks that correct one of them"
        )
    assert isinstance(base, Constant | Ssm | FuzzyExpert)
    return base
