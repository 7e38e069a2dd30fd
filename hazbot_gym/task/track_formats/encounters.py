"""Encounters of people with a real robot: a table with a recording for each of them.

Columns, in any order, one row for each agent at each time:

| column | meaning |
|---|---|
| ``scene``, ``encounter`` | together the number of the encounter |
| ``scenario``, ``behaviour`` | free text: kind of encounter, and how the robot drove |
| ``robot`` | name of the robot; its radius is in ``ROBOTS`` or in the column ``robot_radius_m`` |
| ``t_s`` | time, on a clock of equal steps [s] |
| ``agent`` | ``robot``, or the number of a person |
| ``x_m``, ``y_m`` | position [m] |

The format is that of the tracks selected from NavWareSet (IJRR 2025).
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_checks import median_speed, walking_speed
from hazbot_gym.task.track_formats.table import MOST_BYTES
from hazbot_gym.task.tracks import Reading, RecordedRobot, Recording

if TYPE_CHECKING:
    import pandas as pd

NEEDED = ("scene", "scenario", "robot", "behaviour", "encounter", "t_s", "agent", "x_m", "y_m")
RADIUS = "robot_radius_m"
ROBOT = "robot"  # the agent that is no person
# Radius of a disc with the area of the robot's base [m].
ROBOTS = {
    "hsr": 0.22,  # Toyota HSR: a round base
    "jackal": 0.27,  # Clearpath Jackal: 0.51 m x 0.43 m
}
SMOOTHED = 5  # samples of a moving average, against the noise of the tracker
_OFF_CLOCK = 0.25  # largest distance of a time from its step, in steps


def is_encounters(path: Path) -> bool:
    """Return True if the first line of a file names the columns of encounters."""
    try:
        with path.open(encoding="utf-8-sig") as file:
            names = file.readline(4096).strip().split(",")
    except (OSError, UnicodeDecodeError):
        return False
    return set(NEEDED) <= {name.strip() for name in names}


def read_encounters(path: Path) -> list[Recording]:
    """Return a recording of each encounter, named by scenario, robot, behaviour and number.

    Positions are smoothed by a moving average over five samples.

    Raises:
        InvalidInput: A value cannot be used; one line says where.
    """
    import pandas as pd

    if path.stat().st_size > MOST_BYTES:
        raise InvalidInput(f"{path.name}: has more than {MOST_BYTES >> 20} MiB")
    try:
        rows = pd.read_csv(path, dtype=str, keep_default_na=False, skipinitialspace=True)
    except (OSError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise InvalidInput(f"{path.name}: cannot be read ({reason})") from None
    if rows.empty:
        raise InvalidInput(f"{path.name}: has no rows")
    for name in ("t_s", "x_m", "y_m"):
        rows[name] = _numbers(rows[name], f"{path.name}: {name}")
    groups = rows.groupby(["scene", "encounter"], sort=False)
    return [_recording(path.name, found) for _, found in groups]


def _numbers(column: pd.Series, where: str) -> pd.Series:
    import pandas as pd

    values = pd.to_numeric(column, errors="coerce")
    wrong = ~np.isfinite(values)
    if wrong.any():
        row = int(wrong.to_numpy().argmax())
        raise InvalidInput(f"{where}: line {row + 2} is {column.iloc[row]!r}, allowed is a number")
    return values.astype(np.float64)


def _recording(file: str, rows: pd.DataFrame) -> Recording:
    """Return the recording of the rows of an encounter."""
    first = rows.iloc[0]
    number = f"{first['scene']}.{first['encounter']}"
    where = f"{file}: encounter {number}"
    for name in ("scenario", "robot", "behaviour"):
        if (rows[name] != first[name]).any():
            raise InvalidInput(f"{where}: {name} is not the same in all of its rows")
    steps, dt_s = _clock(rows["t_s"].to_numpy(), where)
    points = rows[["x_m", "y_m"]].to_numpy()
    agents = rows["agent"].to_numpy()
    tracks = {
        agent: _track(steps[agents == agent], points[agents == agent], f"{where}: agent {agent}")
        for agent in dict.fromkeys(agents)
    }
    if ROBOT not in tracks or len(tracks) < 2:
        missing = f"agent {ROBOT!r}" if ROBOT not in tracks else "person"
        raise InvalidInput(f"{where}: has no {missing}")
    began, driven = tracks.pop(ROBOT)
    if any(start < began or start + len(it) > began + len(driven) for start, it in tracks.values()):
        raise InvalidInput(f"{where}: the robot is not recorded as long as the people")
    speeds = walking_speed(*_flat(tracks), 1.0 / dt_s)
    return Recording(
        name=f"{first['scenario']}-{first['robot']}-{first['behaviour']}-{number}",
        dt_s=dt_s,
        ids=np.arange(1, len(tracks) + 1),
        first_steps=np.array([start - began for start, _ in tracks.values()]),
        lengths=np.array([len(track) for _, track in tracks.values()]),
        positions=np.concatenate([track for _, track in tracks.values()]),
        robot=RecordedRobot(
            name=first["robot"],
            radius_m=_radius(rows, where),
            scenario=first["scenario"],
            behaviour=first["behaviour"],
            scene=first["scene"],
            positions=driven,
        ),
        reading=Reading(
            "encounters with a robot", "columns", "m", "columns", 1.0 / dt_s, "time column",
            median_speed(speeds) if len(speeds) else 0.0,
        ),
    )  # fmt: skip


def _clock(times_s: Floats, where: str) -> tuple[Ints, float]:
    """Return the step of each time, and the time step of the encounter [s]."""
    known = np.unique(times_s)
    if len(known) < SMOOTHED:
        raise InvalidInput(f"{where}: has {len(known)} times, allowed are {SMOOTHED} or more")
    dt_s = round(float(np.median(np.diff(known))), 6)
    exact = (times_s - known[0]) / dt_s if dt_s > 0.0 else np.full(len(times_s), np.nan)
    steps = np.rint(exact)
    if not np.all(np.abs(exact - steps) <= _OFF_CLOCK):
        raise InvalidInput(f"{where}: t_s has no equal steps")
    return steps.astype(np.int64), dt_s


def _track(steps: Ints, points: Floats, where: str) -> tuple[int, Floats]:
    """Return an agent's first step, and its smoothed positions (n, 2) from there on."""
    order = np.argsort(steps, kind="stable")
    steps, points = steps[order], points[order]
    if np.any(np.diff(steps) != 1):
        raise InvalidInput(f"{where}: is not seen once at each step from its first to its last")
    half = SMOOTHED // 2
    padded = np.pad(points, ((half, half), (0, 0)), mode="edge")
    window = np.full(SMOOTHED, 1.0 / SMOOTHED)
    smooth = np.stack([np.convolve(axis, window, "valid") for axis in padded.T], axis=1)
    return int(steps[0]), smooth


def _flat(tracks: dict[str, tuple[int, Floats]]) -> tuple[Ints, Ints, Floats]:
    """Return person, step and position of all sightings."""
    ids = [np.full(len(track), i) for i, (_, track) in enumerate(tracks.values())]
    steps = [start + np.arange(len(track)) for start, track in tracks.values()]
    positions = [track for _, track in tracks.values()]
    return np.concatenate(ids), np.concatenate(steps), np.concatenate(positions)


def _radius(rows: pd.DataFrame, where: str) -> float:
    """Return the robot's radius [m]."""
    name = str(rows["robot"].iloc[0])
    if RADIUS in rows:
        radius_m = float(_numbers(rows[RADIUS], f"{where}: {RADIUS}").iloc[0])
        if not 0.0 < radius_m <= 2.0:
            raise InvalidInput(f"{where}: {RADIUS} is {radius_m}, allowed is above 0 and up to 2")
        return radius_m
    if name not in ROBOTS:
        raise InvalidInput(
            f"{where}: robot is {name!r}, allowed are {', '.join(ROBOTS)}, or any name with a "
            f"column {RADIUS}"
        )
    return ROBOTS[name]
