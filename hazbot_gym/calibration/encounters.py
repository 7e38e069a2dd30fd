"""Calibration of people's reaction to the robot on recorded encounters, and its evaluation.

The people of an encounter walk by the social force model beside the recorded robot
(``encounter_walk``). Constants of the force by the robot are fitted on some scenes; the others are
held out. Reactions differ between people: the gain of the force is log-normal, represented by five
equally likely values.

The loss of a group of encounters (a scenario with a robot), in units of a tenth:

    sum over p10, p50, p90 of (d - d')^2 / 0.1^2 + (s - s')^2 / 0.1^2

with the closest distance d [m] and the median s of the slowest speed relative to the own pace.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hazbot_gym.calibration.encounter_walk import (
    Outcome,
    Stage,
    meeting_of,
    model_outcome,
    recorded_outcome,
    stage_of,
)
from hazbot_gym.core.social_force import ATTENTIVE, HELBING_MOLNAR_1995, Reaction, SocialForce
from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.task.places import load_place
from hazbot_gym.task.track_folders import read_all
from hazbot_gym.task.tracks import Recording
from hazbot_gym.utils.json_object import JsonObject

try:
    from scipy.optimize import differential_evolution
    from scipy.stats import norm
except ImportError as error:
    raise MissingExtra("scipy", "study") from error

# Scenarios whose people stand in the way: model people who stand do not step aside.
STANDING = ("obstruction",)
QUANTILES = (0.1, 0.5, 0.9)
GOAL = 0.1  # largest difference of a quantile [m] or of a relative speed
SHARES = (0.1, 0.3, 0.5, 0.7, 0.9)  # of the log-normal gain, equally likely
GENERATIONS, CANDIDATES_EACH = 16, 6  # of the search
DRAWS = 1000  # of the bootstrap of recorded quantiles
LEVEL = 0.95

Group = tuple[str, str]  # scenario and robot
Outcomes = dict[Group, list[Outcome]]


class Response(NamedTuple):
    """Constants of people's response to the robot."""

    robot_strength_mps2: float
    robot_range_m: float
    robot_step_time_s: float
    robot_sidestep_mps2: float
    noticed_m: float  # clearance from which the robot is noticed
    gain_spread: float  # standard deviation of the logarithm of the gain

    def force(self) -> SocialForce:
        """Return the constants of the walking model."""
        return SocialForce()._replace(
            robot_strength_mps2=self.robot_strength_mps2,
            robot_range_m=self.robot_range_m,
            robot_step_time_s=self.robot_step_time_s,
            robot_sidestep_mps2=self.robot_sidestep_mps2,
        )

    def reactions(self) -> list[Reaction]:
        """Return equally likely reactions."""
        gains = np.exp(self.gain_spread * norm.ppf(SHARES))
        return [Reaction(gain=float(gain), range_m=self.noticed_m) for gain in gains]


BOUNDS = ((0.2, 12.0), (0.03, 0.6), (0.0, 3.0), (0.0, 2.0), (0.5, 6.0), (0.0, 1.5))
SHIPPED = Response(
    robot_strength_mps2=SocialForce().robot_strength_mps2,
    robot_range_m=SocialForce().robot_range_m,
    robot_step_time_s=SocialForce().robot_step_time_s,
    robot_sidestep_mps2=SocialForce().robot_sidestep_mps2,
    noticed_m=ATTENTIVE.range_m,
    gain_spread=0.0,
)
PUBLISHED = Response(  # for people among people, who notice each other from afar
    robot_strength_mps2=HELBING_MOLNAR_1995.robot_strength_mps2,
    robot_range_m=HELBING_MOLNAR_1995.robot_range_m,
    robot_step_time_s=HELBING_MOLNAR_1995.robot_step_time_s,
    robot_sidestep_mps2=HELBING_MOLNAR_1995.robot_sidestep_mps2,
    noticed_m=4.0,
    gain_spread=0.0,
)


class Met(NamedTuple):
    """Encounters, and the scene of each."""

    stages: list[Stage]
    scenes: list[str]

    def of(self, scenes: Sequence[str]) -> Met:
        """Return the encounters of some scenes."""
        chosen = [i for i, scene in enumerate(self.scenes) if scene in scenes]
        return Met([self.stages[i] for i in chosen], [self.scenes[i] for i in chosen])


def load_encounters(path: Path) -> list[Recording]:
    """Return the encounters of a file or folder.

    Raises:
        InvalidInput: There is none, or a file cannot be read.
    """
    found = read_all(path)
    if found.faults:
        raise InvalidInput("; ".join(found.faults))
    recordings = [each for each in found.recordings if each.robot is not None]
    if not recordings:
        raise InvalidInput(f"encounters: {str(path)!r} holds no encounter of people with a robot")
    return recordings


def staged(recordings: Sequence[Recording]) -> Met:
    """Return the encounters whose people walk and are seen throughout.

    Raises:
        InvalidInput: There is none.
    """
    like, stages, scenes = load_place("open"), [], []
    for recording in recordings:
        meeting = meeting_of(recording)
        if meeting is not None and meeting.robot.scenario not in STANDING:
            stages.append(stage_of(meeting, like))
            scenes.append(meeting.robot.scene)
    if not stages:
        raise InvalidInput("encounters: given none whose people walk and are seen throughout")
    return Met(stages, scenes)


def split(met: Met, fit: Sequence[str] = ()) -> tuple[Met, Met]:
    """Return the encounters to fit on and the held-out ones, by scene.

    Without names every other scene of a scenario and robot is fitted on. They begin with the first
    or the second, so that neither robots nor behaviours that alternate end up in the same half.

    Raises:
        InvalidInput: There is no such scene, or none is held out.
    """
    known = sorted(set(met.scenes), key=_in_order)
    chosen = list(fit) or _every_other(met, known)
    unknown = [scene for scene in chosen if scene not in known]
    if unknown:
        raise InvalidInput(f"fit: given scene {unknown[0]!r}, allowed are {', '.join(known)}")
    held_out = [scene for scene in known if scene not in chosen]
    if not held_out:
        raise InvalidInput("fit: given all scenes, allowed are fewer: some must be held out")
    return met.of(chosen), met.of(held_out)


def _every_other(met: Met, known: list[str]) -> list[str]:
    groups: dict[Group, list[str]] = {}
    for scene in known:
        groups.setdefault(_group(met.stages[met.scenes.index(scene)]), []).append(scene)
    return [
        scene
        for k, group in enumerate(sorted(groups))
        for scene in groups[group][(k + k // 2) % min(2, len(groups[group])) :: 2]
    ]


def _in_order(scene: str) -> tuple[int, str]:
    return (int(scene), "") if scene.isdigit() else (1 << 60, scene)


def _group(stage: Stage) -> Group:
    return stage.meeting.robot.scenario, stage.meeting.robot.name


# --- the fit -------------------------------------------------------------------------------------


def outcomes(met: Met, response: Response | None) -> Outcomes:
    """Return the outcomes by group: recorded without a response, else those of the model."""
    found: Outcomes = {}
    for key, stage in enumerate(met.stages):
        mine = found.setdefault(_group(stage), [])
        if response is None:
            mine.append(recorded_outcome(stage.meeting))
        else:
            force = response.force()
            mine += [
                model_outcome(stage, force, reaction, key=key) for reaction in response.reactions()
            ]
    return found


def summary(outcomes: Sequence[Outcome]) -> Floats:
    """Return closest distance at p10, p50, p90 [m], and the median of the slowest speed (4,)."""
    closest_m = [each.closest_m for each in outcomes]
    slowest = [each.slowest for each in outcomes if np.isfinite(each.slowest)]
    return np.append(np.quantile(closest_m, QUANTILES), np.median(slowest) if slowest else np.nan)


def loss(met: Met, response: Response, recorded: Outcomes) -> float:
    """Return the loss of a response; statistics that are not defined do not count."""
    model = outcomes(met, response)
    errors = [summary(model[group]) - summary(recorded[group]) for group in recorded]
    return float(np.nansum(np.square(errors)) / GOAL**2)


def fit(
    met: Met, recorded: Outcomes, *, seed: int, on_progress: Callable[[], None] = lambda: None
) -> Response:
    """Return the response of least loss, rounded to three digits.

    Args:
        met: Encounters to fit on.
        recorded: Their outcomes.
        seed: Seed of the differential evolution (Storn and Price 1997).
        on_progress: Called after each of ``GENERATIONS`` generations.
    """
    best = differential_evolution(
        lambda values: loss(met, Response(*map(float, values)), recorded),
        list(BOUNDS),
        maxiter=GENERATIONS,
        popsize=CANDIDATES_EACH,
        rng=np.random.default_rng(seed),
        polish=False,  # quantiles of few encounters are not smooth
        callback=lambda intermediate_result: on_progress(),
    )
    return Response(*(float(f"{value:.3g}") for value in best.x))


# --- the report ----------------------------------------------------------------------------------


def report(fitted: Met, held_out: Met, response: Response) -> JsonObject:
    """Return recorded and model people side by side, for JSON and tables."""
    return {
        "goal": GOAL,
        "response": response._asdict(),
        "published": PUBLISHED._asdict(),
        "encounters": {"fitted on": len(fitted.stages), "held out": len(held_out.stages)},
        "loss": {
            side: {
                "fitted": loss(met, response, outcomes(met, None)),
                "published": loss(met, PUBLISHED, outcomes(met, None)),
            }
            for side, met in (("fitted on", fitted), ("held out", held_out))
        },
        "groups": [
            {"fitted_on": met is fitted, **row}
            for met in (fitted, held_out)
            for row in _rows(met, response)
        ],
    }


def _rows(met: Met, response: Response) -> list[JsonObject]:
    recorded, model = outcomes(met, None), outcomes(met, response)
    published, rows = outcomes(met, PUBLISHED), []
    for group in sorted(recorded):
        real, mine = summary(recorded[group]), summary(model[group])
        rows.append(
            {
                "scenario": group[0],
                "robot": group[1],
                "encounters": len(recorded[group]),
                "recorded": _listed(real),
                "recorded_intervals": _intervals(recorded[group]),
                "model": _listed(mine),
                "published": _listed(summary(published[group])),
                "largest_difference_m": float(np.abs(mine - real)[:-1].max()),
                "slowest_difference": _or_none(abs(float(mine[-1] - real[-1]))),
            }
        )
    return rows


def _intervals(recorded: Sequence[Outcome]) -> list[list[float | None]]:
    """Return bootstrap intervals over encounters, of statistics that are defined."""
    rng, tail = np.random.default_rng(0), (1.0 - LEVEL) / 2.0
    draws = [
        summary([recorded[i] for i in rng.integers(len(recorded), size=len(recorded))])
        for _ in range(DRAWS)
    ]
    defined = [column[np.isfinite(column)] for column in np.transpose(draws)]
    return [
        [float(bound) for bound in np.quantile(column, (tail, 1.0 - tail))]
        if len(column)
        else [None, None]
        for column in defined
    ]


def _listed(values: Floats) -> list[float | None]:
    return [_or_none(float(value)) for value in values]


def _or_none(value: float) -> float | None:
    return value if np.isfinite(value) else None
