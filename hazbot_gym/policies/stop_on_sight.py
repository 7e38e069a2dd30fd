"""The rule of the simplest mobile robots: stop if something is near ahead, go on when it is gone.

Two thresholds instead of one keep it from stuttering (hysteresis). It looks at the two ultrasonic
sensors in front alone, so it takes walls for people, and does not see who comes from the side.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from annotated_types import Gt
from pydantic import ConfigDict, model_validator
from pydantic.dataclasses import dataclass

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import Actions, Observations, speed_action
from hazbot_gym.task.observation import layout_of


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class StopOnSight:
    """Stops below one distance ahead and drives on at nominal speed above another."""

    stop_m: Annotated[float, Gt(0)] = 0.8
    resume_m: Annotated[float, Gt(0)] = 1.2

    @model_validator(mode="after")
    def _resumes_farther_away(self) -> StopOnSight:
        if self.resume_m < self.stop_m:
            raise ValueError(f"must be at least stop_m = {self.stop_m}")
        return self

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, npt.NDArray[np.bool_]]:
        """Return the action, and as state whether the robot is stopped: (N,) or ().

        See ``base.Policy.predict``.
        """
        ahead_m = _ahead_m(observation)
        was_stopped = np.zeros(ahead_m.shape, np.bool_) if state is None else np.asarray(state)
        if episode_start is not None:
            was_stopped = was_stopped & ~np.asarray(episode_start).reshape(ahead_m.shape)
        is_stopped = np.where(was_stopped, ahead_m < self.resume_m, ahead_m < self.stop_m)
        return speed_action(np.where(is_stopped, 0.0, 1.0)), is_stopped


def _ahead_m(observation: Observations) -> Floats:
    seen = layout_of(observation).decode(observation)
    return np.minimum(seen["range_front_left_m"], seen["range_front_right_m"])
