"""Rendering of a batch of worlds: one picture per world, as of a single environment.

A step only records a few numbers per world; drawing is deferred to a request.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats
from hazbot_gym.envs.batch_step import Bools, Outputs
from hazbot_gym.envs.batch_variants import Variants
from hazbot_gym.envs.frame import Frame
from hazbot_gym.envs.plume import gas_frame_of
from hazbot_gym.envs.viewer import TRAIL_STEPS, castor_of, frame_of, pictured_terms
from hazbot_gym.errors import InvalidInput
from hazbot_gym.sim.batched_worlds import Worlds
from hazbot_gym.task.outcome import MOVING_MPS, OUTCOME_NAMES, RUNNING
from hazbot_gym.task.reward import weights_of

if TYPE_CHECKING:
    from hazbot_gym.envs.rendering import Painter


class BatchViewer:
    """Renderer of a batch, with the history that worlds do not store."""

    def __init__(self, mode: str, config: Config, worlds: int, variants: Variants) -> None:
        if mode != "rgb_array":
            raise InvalidInput(
                f"render_mode: given {mode!r}, allowed for a batch are None and 'rgb_array'"
            )
        self._config, self._variants = config, variants
        self._trails: deque[Floats] = deque(maxlen=TRAIL_STEPS + 1)  # (N, 2) at each instant
        self._instants = np.zeros(worlds, np.int64)  # of the running episode
        self._driven = np.zeros((worlds, 2))  # speed and yaw rate when the robot last moved
        self._terms = np.zeros((worlds, len(weights_of(config))))  # weighted, of the last decision
        self._returns = np.zeros(worlds)
        self._outcomes = np.zeros(worlds, np.int64)
        self._painter: Painter | None = None

    def see(self, worlds: Worlds, outputs: Outputs, mask: Bools, fresh: Bools) -> None:
        """Record the state after a reset or step of the worlds in a mask."""
        robots, stepped = worlds.robots, mask & ~fresh
        self._trails.append(np.stack([robots["x"], robots["y"]], axis=1))
        self._instants = np.where(fresh, 1, self._instants + 1)
        for i in np.flatnonzero(stepped).tolist():
            self._terms[i] = outputs.terms[i] * self._variants.of(i).problem.weights
        self._returns[stepped] += self._terms[stepped].sum(axis=1)
        self._outcomes[stepped] = outputs.records["outcome"][stepped]
        has_moved = np.abs(robots["v"]) > MOVING_MPS
        self._driven[has_moved] = np.stack([robots["v"], robots["omega"]], axis=1)[has_moved]
        for noted in (self._terms, self._returns, self._outcomes):
            noted[fresh] = 0
        self._driven[fresh & ~has_moved] = 0.0

    def pictures(
        self, worlds: Worlds, time_s: Floats, which: range
    ) -> tuple[npt.NDArray[np.uint8], ...]:
        """Return the pictures of some worlds, all of one size (H, W, 3)."""
        if not self._trails:
            raise InvalidInput("render: no episode has begun, call reset first")
        frames = [self._frame(i, worlds, float(time_s[i])) for i in which]
        if self._painter is None:
            from hazbot_gym.envs.rendering import Painter

            place = self._variants.of(0).place(int(worlds.places[0]))
            self._painter = Painter(place, has_strip=frames[0].has_strip)
        return tuple(map(self._painter.paint, frames))

    def __getstate__(self) -> dict[str, object]:
        """Return the picklable state, without the painter."""
        return {**self.__dict__, "_painter": None}

    def _frame(self, i: int, worlds: Worlds, time_s: float) -> Frame:
        outcome, variant = self._outcomes[i], self._variants.of(i)
        trail = list(self._trails)[-min(self._instants[i], TRAIL_STEPS) :]
        return frame_of(
            variant.config,
            variant.place(int(worlds.places[i])),
            worlds.robots[i],
            people=worlds.people[i],
            patterns=worlds.tracks[i]["pattern"].tolist(),
            ranges_m=worlds.ranges[i],
            trail=np.array([at[i] for at in trail]),
            castor_rad=castor_of(self._driven[i, 0], self._driven[i, 1], self._config),
            terms=pictured_terms(self._config, self._terms[i]),
            total_reward=float(self._returns[i]),
            time_s=time_s,
            outcome="" if outcome == RUNNING else OUTCOME_NAMES[outcome],
            gas=gas_frame_of(self._config, worlds.gas[i : i + 1], int(worlds.keys[i])),
        )
