"""Calibration of the social force model on recorded corridors, and its evaluation.

The recorded people of a corridor are simulated without a robot: they enter at the recorded time,
place and speed and leave at the recorded place; the model determines the motion between. Four
constants are fitted on some runs; the other runs are held out. Both recordings are cut to the
corridor.

The loss of a run, in units of a tenth of a metre or metre per second and of a twentieth of people:

    mean over bins of (u - u')^2 / 0.1^2 + sum over distances of (d - d')^2 / (2 0.1^2)
        + (share not let in)^2 / 0.05^2

with the mean speed u in each bin of density, and the distances d to the nearest neighbour (mean,
p5) and of passing (medians of encountering and confronting pairs).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Clock, Speeds
from hazbot_gym.core.entries import seat
from hazbot_gym.core.social_force import HELBING_MOLNAR_1995, SocialForce
from hazbot_gym.core.state import (
    PERSON,
    PERSON_RADIUS_M,
    PRESENT,
    SOCIAL_FORCE,
    Floats,
    Place,
    Records,
    records,
)
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.sim.unattended import walk_in_parts
from hazbot_gym.task.crowd import SPEED_HIGH_MPS, SPEED_LOW_MPS
from hazbot_gym.task.density import BIN_EDGES, Bin, fundamental_diagram
from hazbot_gym.task.recorded import inside_corridor, recorded_places
from hazbot_gym.task.track_folders import load_tracks
from hazbot_gym.task.track_statistics import Statistics, statistics
from hazbot_gym.task.tracks import Recording

try:
    from scipy.optimize import differential_evolution
except ImportError as error:
    raise MissingExtra("scipy", "study") from error

FITTED_ON = ("boa-300-050-070", "uo-100-180-180")  # one run each of two and of one direction
# Fitted constants and their bounds, without those towards a robot: no recording contains one.
BOUNDS = {
    "person_strength_mps2": (0.5, 10.0),
    "person_range_m": (0.05, 0.6),
    "step_time_s": (0.2, 3.0),
    "sidestep_mps2": (0.0, 4.0),
}
PASSING = ("encountering", "confronting")
GENERATIONS, CANDIDATES_EACH = 40, 10  # of the search
GOAL_MPS = 0.2  # largest difference of mean speeds in a bin, on held-out runs
KEYS = (1, 2)  # of the fluctuations
RECORDS_AT_ONCE = 1_000_000  # simulated people, 140 bytes each; only sightings are kept
MISSING_BIN_MPS = 0.4  # speed error of a density that the model never reaches


class Walked(NamedTuple):
    """Compared statistics of a corridor recording."""

    people: int
    bins: dict[float, Bin]  # by lower edge
    numbers: Statistics


class Run(NamedTuple):
    """Recorded people and the place of their simulation."""

    recording: Recording
    place: Place
    real: Walked


def load_runs(folder: Path) -> dict[str, Run]:
    """Return the corridor runs with enough densities to compare, by name.

    Raises:
        InvalidInput: no file can be read, or no run is of a corridor.
    """
    recordings = load_tracks(folder)
    runs = (_run(recording) for recording in recordings if recording.corridor)
    found = {run.recording.name: run for run in runs if run.real.bins}
    if not found:
        raise InvalidInput(f"tracks: {str(folder)!r} holds no recording of people in a corridor")
    return found


def split(runs: dict[str, Run], fit: tuple[str, ...]) -> tuple[list[Run], list[Run]]:
    """Return the runs to fit on and the held-out runs.

    Raises:
        InvalidInput: a run to fit on is missing, or no run is held out.
    """
    unknown = [name for name in fit if name not in runs]
    if unknown:
        raise InvalidInput(f"fit: given {unknown[0]!r}, allowed are {', '.join(sorted(runs))}")
    held_out = [run for name, run in runs.items() if name not in fit]
    if not held_out:
        raise InvalidInput("fit: leaves no run to judge by")
    return [runs[name] for name in fit], held_out


def fit(
    runs: list[Run], *, seed: int, on_progress: Callable[[], None] = lambda: None
) -> SocialForce:
    """Return the constants of least loss over some runs, rounded to three digits.

    Args:
        runs: to fit on.
        seed: seed of the differential evolution (Storn and Price 1997).
        on_progress: called after each of ``GENERATIONS`` generations.
    """
    best = differential_evolution(
        lambda values: sum(loss(run, _force(values)) for run in runs),
        list(BOUNDS.values()),
        maxiter=GENERATIONS,
        popsize=CANDIDATES_EACH,
        rng=np.random.default_rng(seed),
        polish=False,  # the loss is discontinuous where a person passes on the other side
        callback=lambda intermediate_result: on_progress(),
    )
    return _force([float(f"{value:.3g}") for value in best.x])


def loss(run: Run, force: SocialForce) -> float:
    """Return the loss of a run, averaged over noise realizations of the model."""
    return float(np.mean([_distance(run, walk_again(run, force, key=key)) for key in KEYS]))


def _distance(run: Run, model: Walked) -> float:
    real = run.real
    speeds = [
        model.bins[edge].speed_mps - there.speed_mps if edge in model.bins else MISSING_BIN_MPS
        for edge, there in real.bins.items()
    ]
    gaps = np.subtract(_distances(model), _distances(real))
    outside = 1.0 - model.people / len(run.place.entry_times_s)
    total = np.mean(np.square(speeds)) / 0.1**2 + np.nansum(gaps**2) / (2.0 * 0.1**2)
    return float(total + outside**2 / 0.05**2)


def walk_again(run: Run, force: SocialForce, *, key: int = KEYS[0]) -> Walked:
    """Simulate the people of a run with the social force model."""
    dt_s = Clock().social_s
    people = records(PERSON, len(run.place.entry_times_s))
    for entry, person in enumerate(people.view(np.recarray)):
        person.model, person.radius = SOCIAL_FORCE, PERSON_RADIUS_M
        seat(person, run.place, entry, 0.0)
    steps = int(run.recording.duration_s / dt_s) + 1
    parts = walk_in_parts(
        people, run.place, force, key=key, steps=steps, dt_s=dt_s,
        part=math.ceil(RECORDS_AT_ONCE / max(len(people), 1)),
    )  # fmt: skip
    return _walked(_as_recording(run.recording, parts, dt_s))


def with_drawn_speeds(run: Run, speeds: Speeds, *, seed: int) -> Run:
    """Return a run with drawn preferred speeds instead of recorded ones."""
    drawn = np.random.default_rng(seed).normal(
        speeds.mean_mps, speeds.sd_mps, len(run.place.entry_times_s)
    )
    speeds_mps = np.clip(drawn, SPEED_LOW_MPS, SPEED_HIGH_MPS)
    return run._replace(place=run.place._replace(entry_speeds_mps=speeds_mps))


def report(fitted: list[Run], held_out: list[Run], force: SocialForce) -> dict[str, object]:
    """Return the comparison of real and simulated people, for JSON and tables."""
    return {
        "goal_mps": GOAL_MPS,
        "densest_per_m2": BIN_EDGES[-1],
        "fitted": {name: getattr(force, name) for name in BOUNDS},
        "shipped": {name: getattr(SocialForce(), name) for name in BOUNDS},
        "helbing_molnar_1995": {name: getattr(HELBING_MOLNAR_1995, name) for name in BOUNDS},
        "loss": {
            "fitted": sum(loss(run, force) for run in fitted),
            "shipped": sum(loss(run, SocialForce()) for run in fitted),
            "helbing_molnar_1995": sum(loss(run, HELBING_MOLNAR_1995) for run in fitted),
        },
        "runs": [
            {"run": run.recording.name, "fitted_on": run in fitted, **_compare(run, force)}
            for run in (*fitted, *held_out)
        ],
    }


def _compare(run: Run, force: SocialForce) -> dict[str, object]:
    sides = {
        "real": run.real,
        "model": walk_again(run, force),
        "drawn speeds": walk_again(with_drawn_speeds(run, Speeds(), seed=KEYS[0]), force),
        "helbing_molnar_1995": walk_again(run, HELBING_MOLNAR_1995),
    }
    return {
        "came_in": len(run.place.entry_times_s),
        "sides": {name: _row(walked) for name, walked in sides.items()},
        "largest_speed_difference_mps": {
            name: max(_speed_differences(run.real, walked), default=None)
            for name, walked in sides.items()
            if name != "real"
        },
    }


def _row(walked: Walked) -> dict[str, object]:
    nearest_mean, nearest_p5, *passing = (_or_none(value) for value in _distances(walked))
    return {
        "people": walked.people,
        "person_speed_mps": walked.numbers.person_speed_mps,
        "person_speed_sd_mps": walked.numbers.person_speed_sd_mps,
        "speed_percentiles_mps": list(walked.numbers.speed_percentiles_mps),
        "nearest_mean_m": nearest_mean,
        "nearest_p5_m": nearest_p5,
        **{f"{name}_m": value for name, value in zip(PASSING, passing, strict=True)},
        "bins": [each._asdict() for each in walked.bins.values()],
    }


def _speed_differences(real: Walked, model: Walked) -> Iterator[float]:
    """Yield the absolute difference in every bin with data from both."""
    for edge in BIN_EDGES:
        if edge in real.bins and edge in model.bins:
            yield abs(real.bins[edge].speed_mps - model.bins[edge].speed_mps)


def _distances(walked: Walked) -> Floats:
    numbers = walked.numbers
    passing = [numbers.patterns[name].closest_m[1] for name in PASSING]
    return np.array([numbers.nearest_mean_m, numbers.nearest_p5_m, *passing])


def _or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _force(values: list[float] | Floats) -> SocialForce:
    return SocialForce()._replace(**dict(zip(BOUNDS, map(float, values), strict=True)))


def _run(recording: Recording) -> Run:
    place = recorded_places([recording], with_entries=True)[0]
    return Run(recording, place, _walked(inside_corridor(recording)))


def _walked(recording: Recording) -> Walked:
    bins = {each.low: each for each in fundamental_diagram(recording)}
    return Walked(recording.people, bins, statistics(recording))


def _as_recording(like: Recording, parts: Iterable[Records], dt_s: float) -> Recording:
    """Convert chunks of records (T, P) to a recording of the people who entered."""
    rows, first = [], 0
    for seen in parts:
        step, person = np.nonzero(seen["status"] == PRESENT)
        there = seen[step, person]
        rows.append(np.stack([person, first + step, there["x"], there["y"]], axis=1))
        first += len(seen)
    sightings = np.concatenate(rows)
    sightings = sightings[np.argsort(sightings[:, 0], kind="stable")]
    ids, starts, lengths = np.unique(sightings[:, 0], return_index=True, return_counts=True)
    came = lengths > 1
    return replace(
        like,
        dt_s=dt_s,
        ids=ids[came].astype(np.int64),
        first_steps=sightings[starts[came], 1].astype(np.int64),
        lengths=lengths[came],
        positions=np.ascontiguousarray(sightings[np.repeat(came, lengths), 2:]),
    )
