"""Base class of rules about gas, beside a rule about people: the slower of both counts."""

from __future__ import annotations

from functools import cached_property
from typing import Literal

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import factory_of
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.task.observation import layout_of

PeopleRules = Literal["none", "fuzzy_expert", "idm", "mpc", "ssm", "velocity_obstacle"]


class GasRule(PeopleRule):
    """Rule that slows down for gas, and for people as the rule of the option ``people`` does.

    After an alarm there is nothing left to find, and only the people count.
    """

    slow: float  # share of the nominal speed while it inspects
    people: PeopleRules

    def inspects(self, seen: dict[str, Floats]) -> npt.NDArray[np.bool_]:
        """Return True where decoded observations call for the slow speed, shape (...)."""
        raise NotImplementedError

    def speed_share(self, observation: Observations) -> npt.ArrayLike:
        """Return the slower of both shares; see ``base.Rule``.

        Raises:
            InvalidInput: The observation has no gas sensor.
        """
        layout = layout_of(observation)
        if not layout.has_gas:
            raise InvalidInput(
                f"gas: given observations of {layout.width} entries without a gas sensor, this "
                "policy needs an environment with gas, such as Inspection-v1"
            )
        seen = layout.decode(observation)
        is_slow = self.inspects(seen) & (seen["gas_alarmed"] < 0.5)
        share = np.where(is_slow, self.slow, 1.0)
        if self.people_rule is None:
            return share
        return np.minimum(share, self.people_rule.speed_share(observation))

    @cached_property
    def people_rule(self) -> PeopleRule | None:
        """Return the rule about people, if any."""
        if self.people == "none":
            return None
        rule: PeopleRule = factory_of(self.people)()
        return rule
