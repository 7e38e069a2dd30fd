"""Viewer of one environment: a picture on request, or a live window."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.kinematics import castor_angle
from hazbot_gym.core.sensor_ring import sensors_of
from hazbot_gym.core.state import Floats, Place, Records
from hazbot_gym.envs.frame import Frame, between
from hazbot_gym.envs.plume import gas_frame_of
from hazbot_gym.errors import InvalidInput
from hazbot_gym.sim.world import World
from hazbot_gym.task.outcome import MOVING_MPS
from hazbot_gym.task.reward import terms_of, weights_of

if TYPE_CHECKING:
    from hazbot_gym.envs.rendering import Painter
    from hazbot_gym.envs.window import Window

MODES = ("human", "rgb_array")
TRAIL_STEPS = 1000  # length of the trail in decisions
TITLE = "hazbot_gym"


class Viewer:
    """Viewer of one environment, with the history that the world does not store.

    pygame is imported at the first picture, and never without a render mode.

    Attributes:
        caption: Text in the corner of the pictures.
    """

    def __init__(self, mode: str | None, config: Config) -> None:
        if mode is not None and mode not in MODES:
            raise InvalidInput(
                f"render_mode: given {mode!r}, allowed are None, {' and '.join(map(repr, MODES))}"
            )
        self._mode, self._config = mode, config
        self._weights = weights_of(config)
        self.caption = ""
        self._before: Frame | None = None
        self._frame: Frame | None = None
        self._painter: Painter | None = None
        self._window: Window | None = None

    def begin(self, config: Config) -> None:
        """Clear the last episode; the next one has a config, which may differ."""
        self._config, self._weights = config, weights_of(config)
        self._trail: deque[tuple[float, float]] = deque(maxlen=TRAIL_STEPS)
        self._castor_rad = self._total_reward = 0.0
        self._frame = None

    def see(
        self, world: World, ranges_m: Floats, patterns: list[int], terms: Floats, outcome: str,
        gas: Records, key: int,
    ) -> None:  # fmt: skip
        """Record the state after a reset or step, and show it in the mode "human".

        Args:
            world: The world.
            ranges_m: (sensors,) ultrasonic readings.
            patterns: The tracked pattern of each person.
            terms: Unweighted reward terms of the decision.
            outcome: Outcome of the episode, or "" while it runs.
            gas: (1,) GAS record; (0,) without gas.
            key: Key of the scenario.
        """
        robot = world.robots[0]
        if abs(robot["v"]) > MOVING_MPS:  # the castor of a standing robot keeps its angle
            self._castor_rad = castor_of(robot["v"], robot["omega"], self._config)
        weighted = terms * self._weights
        self._total_reward += float(weighted.sum())
        self._trail.append((float(robot["x"]), float(robot["y"])))
        self._before = self._frame
        self._frame = frame_of(
            self._config,
            world.place,
            robot,
            people=world.people.copy(),
            patterns=patterns,
            ranges_m=ranges_m.copy(),
            trail=np.array(self._trail),
            castor_rad=self._castor_rad,
            terms=pictured_terms(self._config, weighted),
            total_reward=self._total_reward,
            time_s=world.time_s,
            outcome=outcome,
            gas=gas_frame_of(self._config, gas, key),
            caption=self.caption,
        )
        if self._mode == "human":
            self._show()

    def picture(self) -> npt.NDArray[np.uint8] | None:
        """Return the current picture (H, W, 3); None in other modes than "rgb_array".

        Raises:
            InvalidInput: there has been no reset yet.
        """
        return self._paint() if self._mode == "rgb_array" else None

    @property
    def frame(self) -> Frame:
        """The content of the current picture.

        Raises:
            InvalidInput: there has been no reset yet.
        """
        if self._frame is None:
            raise InvalidInput("render: no episode has begun, call reset first")
        return self._frame

    def picture_between(self, share: float) -> npt.NDArray[np.uint8]:
        """Return the picture a share of the way from the last decision to the present one."""
        if self._before is None or self._frame is None:
            return self._paint()
        return self._paint(between(self._before, self._frame, share))

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()

    def __getstate__(self) -> dict[str, object]:
        """Return the picklable state, without painter and window."""
        return {**self.__dict__, "_painter": None, "_window": None}

    def _show(self) -> None:
        if self._window is None:
            from hazbot_gym.envs.window import Window

            self._window = Window(TITLE, 1.0 / self._config.clock.decision_s)
        if self._window.is_open:
            self._window.show(self._paint())

    def _paint(self, frame: Frame | None = None) -> npt.NDArray[np.uint8]:
        shown = frame or self.frame
        if self._painter is None:
            from hazbot_gym.envs.rendering import Painter

            self._painter = Painter(shown.place, has_strip=shown.has_strip)
        return self._painter.paint(shown)


def castor_of(speed_mps: float, omega: float, config: Config) -> float:
    """Return the castor's angle [rad] of a robot that drives and turns [rad/s]."""
    return castor_angle(speed_mps / omega if omega else math.inf, config.drive.chassis)


def pictured_terms(config: Config, weighted: Floats) -> dict[str, float]:
    """Return weighted reward terms by name; without gas there is room for the sum of a user's."""
    terms = dict(zip(terms_of(config), weighted.tolist(), strict=True))
    own = [terms.pop(name) for name in config.own_terms]
    return terms | {"own terms": sum(own)} if own and config.gas is None else terms


def frame_of(config: Config, place: Place, robot: np.void, **others: Any) -> Frame:
    """Return the frame of a world; ``others`` are the remaining fields of ``Frame``."""
    return Frame(
        place=place,
        x_m=float(robot["x"]),
        y_m=float(robot["y"]),
        theta_rad=float(robot["theta"]),
        speed_mps=float(robot["v"]),
        command_mps=float(robot["command"]),
        sonar=config.sensors.ultrasonic,
        ring=sensors_of(config.sensors.ring),
        top_speed_mps=config.drive.nominal_speed_mps,
        **others,
    )
