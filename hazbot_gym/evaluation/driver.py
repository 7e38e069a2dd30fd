"""A policy in an environment: made for its robot, and reading its observations."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.config.randomised import value_at
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Actions, Observations
from hazbot_gym.policies.made_for import needs_of, parts_of
from hazbot_gym.task.observation import layout_in, observing

SAME = 1e-6  # tolerance of speeds and times
FIELDS = "__dataclass_fields__"  # the options of a policy


def check_made_for(policy: Policy, config: Config, name: str = "") -> None:
    """Refuse a policy that is made for another nominal speed or decision period.

    Args:
        policy: The policy.
        config: Config of the environment.
        name: Name of the policy for the message; default its class.

    Raises:
        InvalidInput: The first difference; one line.
    """
    with observing(config):
        parts = list(parts_of(policy, layout_in(config)))
    for part in parts:
        for field, needed in needs_of(part).items():
            given = value_at(config, field)
            if not abs(given - needed) <= SAME:
                has_option = part is policy and "nominal_mps" in vars(type(part)).get(FIELDS, ())
                remedy = f"; give its option nominal_mps={given:g}" if has_option else ""
                raise InvalidInput(
                    f"{field}: given {given:g}, but {name or type(policy).__name__} is made for "
                    f"{needed:g}{remedy}"
                )


class _Driver:
    """A policy that reads the observations of one environment."""

    def __init__(self, policy: Policy, config: Config) -> None:
        self._policy, self._config = policy, config

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Any]:
        """Return the policy's action and its inner state; see ``Policy.predict``."""
        with observing(self._config):
            return self._policy.predict(
                observation,
                state=state,
                episode_start=episode_start,
                deterministic=deterministic,
            )


def driver_of(policy: Policy, config: Config, name: str = "") -> Policy:
    """Return a policy that can be asked in an environment.

    Args:
        policy: The policy.
        config: Config of the environment.
        name: Name of the policy for the message; default its class.

    Raises:
        InvalidInput: It is made for another robot, or for other observations.
    """
    check_made_for(policy, config, name)
    return _Driver(policy, config)
