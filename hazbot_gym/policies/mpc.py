"""Model predictive control (MPC) with constant-velocity prediction of people.

In every decision the optimal plan over the horizon is computed (``mpc_plan``), and its first speed
is commanded. The objective is the predictable part of the reward in ``task/reward.py``: progress,
smoothness and intrusion with the same formulas, and contact in proportion to the speed. Nearness to
people is measured as the config says (``nearness``). Weights are the reward's; that of intrusion is
multiplied by the sweep parameter. Within the horizon, waiting loses progress; in an episode,
waiting only delays progress. Therefore an intrusion weight above the reward's gives higher returns.

While the robot stands, each person is predicted twice: with the observed velocity, and with its
mirror image at the line of sight; the worse one counts. With the observed one alone, a robot that
waits sets off at people who come head on and for a moment seem to pass.

Not modeled: people who give way, turn, or come into sight; burden, tracking and arrival; the cause
of a contact. The path ahead is predicted with the curvature at 1 m, so that a corner seems to begin
nearer and end farther than it does.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le
from pydantic.dataclasses import dataclass

from hazbot_gym.core.geometry import STRAIGHT_PER_M
from hazbot_gym.core.state import Floats, as_record
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Flags, Observations
from hazbot_gym.policies.mpc_plan import LEVELS, Problem, plan
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.people_seen import People, mirrored, people_seen
from hazbot_gym.policies.robot import ACCELERATION_MPS2, BRAKING_MPS2, DECISION_S, NOMINAL_MPS
from hazbot_gym.task.observation import layout_of

STANDING_MPS = 0.05
PROGRESS, SMOOTHNESS, CONTACT = 1.0, 0.5, 400.0  # weights of the reward, without their signs
INTRUSION = {"depth": 4.0, "discomfort": 0.4}  # by the measure of nearness
NEARNESS: Literal["depth", "discomfort"] = "discomfort"  # the config's default


@dataclass(frozen=True, config=OPTIONS)
class Mpc(PeopleRule):
    """Drives at the first speed of the optimal plan."""

    caution: Annotated[float, Ge(0)] = 16.0  # times the reward's weight, the sweep parameter
    nearness: Literal["depth", "discomfort"] = NEARNESS
    horizon_s: Annotated[float, Gt(0), Le(60)] = 4.0
    nominal_mps: Annotated[float, Ge(0.05)] = NOMINAL_MPS  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the first share of the optimal plan; see ``base.Rule``."""
        seen, shape = layout_of(observation).decode(observation), np.shape(observation)[:-1]
        problem = self._problem()
        places = problem.stages * 2 * LEVELS + 1
        people = _predicted(people_seen(seen), np.abs(seen["speed_mps"]) < STANDING_MPS)
        way = way_ahead(seen["curvature_ahead_per_m"], problem.unit_m * np.arange(float(places)))
        out = np.zeros(math.prod(shape))
        plan(
            people.reshape(-1, *people.shape[-2:]),
            way.reshape(-1, 2, places),
            (seen["speed_mps"] / self.nominal_mps).reshape(-1),
            (seen["command_mps"] / self.nominal_mps).reshape(-1),
            as_record(problem),
            np.zeros((2, LEVELS + 1, places)),
            np.zeros((2, places)),
            out,
        )
        return out.reshape(shape)

    def _problem(self) -> Problem:
        stage_s = self.nominal_mps / LEVELS / ACCELERATION_MPS2  # gains one level
        decisions = stage_s / DECISION_S
        return Problem(
            stages=math.ceil(self.horizon_s / stage_s),
            stage_s=stage_s,
            unit_m=0.5 * self.nominal_mps / LEVELS * stage_s,
            most_down=int(BRAKING_MPS2 / ACCELERATION_MPS2 + 1e-9),
            progress=PROGRESS * decisions / (2 * LEVELS),
            smoothness=SMOOTHNESS / LEVELS**2,
            intrusion=self.caution * INTRUSION[self.nearness] * decisions,
            contact=CONTACT,
            is_rated=self.nearness == "discomfort",
        )


def way_ahead(curvature_per_m: Floats, s: Floats) -> Floats:
    """Return x ahead and y left of path points, (..., 2, S), at arc lengths s (S,)."""
    is_straight = np.abs(curvature_per_m) < STRAIGHT_PER_M
    k = np.where(is_straight, STRAIGHT_PER_M, curvature_per_m)[..., None]
    half = 0.5 * k * s  # half angle formulas: 1 - cos would lose all digits of a line
    chord = np.sin(half) * 2.0 / k
    return np.stack([chord * np.cos(half), chord * np.sin(half)], axis=-2)


def _predicted(people: People, stands: Flags) -> Floats:
    """Return people (..., K), and mirror images where the robot stands, as (..., 5, 2 K)."""
    images = mirrored(people)
    images = images._replace(is_there=people.is_there & stands[..., None])
    both = zip(people, images, strict=True)
    return np.stack([np.concatenate(pair, axis=-1) for pair in both], axis=-2, dtype=np.float64)
