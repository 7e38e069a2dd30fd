"""Stop on sight: stop for an obstacle ahead, resume when it is gone.

Two thresholds prevent chattering (hysteresis). The policy uses only the two front ultrasonic
sensors, so it also stops for walls, and misses people from the side. If the threshold exceeds the
distance at which the cones meet the side walls, the robot stops forever.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from annotated_types import Gt
from pydantic import model_validator
from pydantic.dataclasses import dataclass

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Actions, Flags, Guarded, Observations
from hazbot_gym.task.action import speed_action
from hazbot_gym.task.observation import layout_of

HYSTERESIS_M = 0.4


@dataclass(frozen=True, config=OPTIONS)
class StopOnSight(Guarded):
    """Stops below one distance ahead and resumes nominal speed above another.

    Attributes:
        stop_m: Reading below which it stops; the sweep parameter.
        resume_m: Reading above which it resumes; default ``HYSTERESIS_M`` more.
    """

    stop_m: Annotated[float, Gt(0)] = 0.8
    resume_m: Annotated[float, Gt(0)] | None = None

    @model_validator(mode="after")
    def _resumes_farther_away(self) -> StopOnSight:
        if self.resume_m is not None and self.resume_m < self.stop_m:
            raise ValueError(f"must be at least stop_m = {self.stop_m}")
        return self

    def act(
        self, observation: Observations, state: object, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, Flags]:
        """Return the action, and as state whether the robot is stopped: (N,) or ().

        See ``Guarded.act``.
        """
        ahead_m = _ahead_m(observation)
        was_stopped = np.zeros(ahead_m.shape, np.bool_) if state is None else np.asarray(state)
        if starts is not None:
            was_stopped = was_stopped & ~np.asarray(starts).reshape(ahead_m.shape)
        resume_m = self.stop_m + HYSTERESIS_M if self.resume_m is None else self.resume_m
        is_stopped = np.where(was_stopped, ahead_m < resume_m, ahead_m < self.stop_m)
        return speed_action(np.where(is_stopped, 0.0, 1.0)), is_stopped


def _ahead_m(observation: Observations) -> Floats:
    seen = layout_of(observation).decode(observation)
    return np.minimum(seen["range_front_left_m"], seen["range_front_right_m"])
