"""Replay records: the drives shown in the report, in one parquet file.

A row is one drive of one scenario. It holds walls, path, robot and people, so that drawing needs
neither environment nor policy.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.episode import PERSON_COLUMNS, stack_people
from hazbot_gym.utils.json_object import JsonObject

if TYPE_CHECKING:
    import pandas as pd

BEST = ""  # reserved name: the oracle's drive of a scenario
MOST_CELLS = 50_000_000  # 2 GB; a full study has a tenth of it
SERIES = ("speed_mps", "distance_m", "earned")  # columns with a number per instant
GAS_SERIES = ("reading", "alarm")  # the same, empty without gas
_KEYS = ("scenario_set", "beside_best", "episode")


class Sonar(NamedTuple):
    """The robot's ultrasonic sensors, as far as they are drawn.

    Attributes:
        mount_m: Distance of a sensor from the robot's centre.
        range_m: Reading without an echo.
        axes_rad: Direction of each sensor from the heading.
        half_cones_rad: Half opening angle of each.
    """

    mount_m: float
    range_m: float
    axes_rad: Floats
    half_cones_rad: Floats


class Drive(NamedTuple):
    """Visible part of an episode; fields as in ``Episode``.

    Attributes:
        distance_m: Distance driven since the start.
        earned: Cumulated reward, 0 at the start.
        ranges_m: (T, sensors) readings of the sonar that the policy had at each decision, to the
            centimetre.
        reading: (T + 1,) of the gas sensor, in units of the alarm threshold; (0,) without gas.
        alarm: (T + 1,) 1 while its alarm sounds; (0,) without gas.
        contact: (2,) point where the robot touched a person or wall [m], or (0,).
        is_recorded: Whether it reproduced the episode's recorded metrics. A stochastic policy may
            not.
    """

    time_s: Floats
    pose: Floats
    speed_mps: Floats
    distance_m: Floats
    earned: Floats
    ranges_m: Floats
    reading: Floats
    alarm: Floats
    people: Floats
    contact: Floats
    outcome: str
    contact_caused_by: str
    is_recorded: bool


class Replay(NamedTuple):
    """One scenario of a set with every policy's drive.

    Attributes:
        number: The episode's number in its set.
        why: Reason for which it was chosen, such as ``median``.
        walls: (W, 4) ends of the walls [m].
        path: (n, 2) points of the robot's path [m].
        sonar: Geometry of the sensors.
        leak: (2,) position of the gas leak [m]; (0,) without one.
        runs: The drive of each policy, by name.
        best: The oracle's drive, if the study has one for this scenario.
    """

    number: int
    why: str
    walls: Floats
    path: Floats
    sonar: Sonar
    leak: Floats
    runs: dict[str, Drive]
    best: Drive | None = None


class Replays(NamedTuple):
    """All replays of a study, by set: the selected episodes, and one with the oracle's drive."""

    chosen: dict[str, list[Replay]]
    beside_best: dict[str, Replay]


def rows_of(replays: Replays) -> Iterator[dict[str, object]]:
    """Yield a row for each drive."""
    for name, some in replays.chosen.items():
        for replay in some:
            yield from _rows(name, replay)
    for name, replay in replays.beside_best.items():
        yield from _rows(name, replay)


def from_rows(rows: pd.DataFrame) -> Replays:
    """Return the replays from the rows of ``rows_of``.

    Raises:
        ValueError: These are no such rows.
    """
    found = Replays({}, {})
    try:
        _check_size(rows)
        for (name, is_beside, _), drives in rows.groupby(list(_KEYS), sort=False):
            replay = _replay(drives.to_dict("records"))
            if is_beside:
                found.beside_best[str(name)] = replay
            else:
                found.chosen.setdefault(str(name), []).append(replay)
    except (KeyError, IndexError, TypeError) as error:
        raise ValueError("no rows of replays") from error
    return found


def _check_size(rows: pd.DataFrame) -> None:
    """Reject drives that exceed the memory: each needs a cell per person and instant."""
    columns = zip(rows["time_s"], rows["persons"], strict=True)
    cells = sum(len(times) * len(np.unique(persons)) for times, persons in columns)
    if cells > MOST_CELLS:
        raise ValueError(f"replays of {cells:,} cells, allowed are {MOST_CELLS:,}")


def _rows(name: str, replay: Replay) -> Iterator[dict[str, object]]:
    drives = replay.runs if replay.best is None else {**replay.runs, BEST: replay.best}
    for policy, drive in drives.items():
        yield {
            "scenario_set": name,
            "beside_best": replay.best is not None,
            "episode": replay.number,
            "why": replay.why,
            "policy": policy,
            "walls": _flat(replay.walls),
            "path": _flat(replay.path),
            "sonar": _flat(np.hstack(replay.sonar)),
            "leak": _flat(replay.leak),
            **_columns(drive),
        }


def _columns(drive: Drive) -> dict[str, object]:
    instants, persons = np.nonzero(np.isfinite(drive.people[..., 0]))
    return {
        **{name: _flat(getattr(drive, name)) for name in ("time_s", "pose", *SERIES, *GAS_SERIES)},
        "instants": instants.astype(np.int32),  # instant of each sighting,
        "persons": persons.astype(np.int32),  # person,
        "people": _flat(drive.people[instants, persons]),  # position
        "ranges_cm": np.rint(100.0 * drive.ranges_m).astype(np.int16).ravel(),
        "contact": _flat(drive.contact),
        "outcome": drive.outcome,
        "contact_caused_by": drive.contact_caused_by,
        "is_recorded": drive.is_recorded,
    }


def _replay(rows: list[JsonObject]) -> Replay:
    sonar = _sonar(rows[0]["sonar"])
    drives = {row["policy"]: _drive(row, len(sonar.axes_rad)) for row in rows}
    return Replay(
        number=int(rows[0]["episode"]),
        why=rows[0]["why"],
        walls=_shaped(rows[0]["walls"], 4),
        path=_shaped(rows[0]["path"], 2),
        sonar=sonar,
        leak=np.asarray(rows[0]["leak"], float),
        best=drives.pop(BEST, None),
        runs=drives,
    )


def _sonar(values: object) -> Sonar:
    mount, reach, *angles = np.asarray(values, float)
    axes, half_cones = np.reshape(angles, (2, -1))
    return Sonar(round(mount, 4), round(reach, 4), axes, half_cones)


def _drive(row: JsonObject, sensors: int) -> Drive:
    time_s = np.asarray(row["time_s"], float)
    people = _shaped(row["people"], len(PERSON_COLUMNS))
    _, stacked = stack_people(row["instants"], row["persons"], people, len(time_s))
    return Drive(
        time_s=time_s,
        pose=_shaped(row["pose"], 3),
        **{name: np.asarray(row[name], float) for name in (*SERIES, *GAS_SERIES)},
        ranges_m=_shaped(row["ranges_cm"], sensors) / 100.0,
        people=stacked,
        contact=np.asarray(row["contact"], float),
        outcome=row["outcome"],
        contact_caused_by=row["contact_caused_by"],
        is_recorded=bool(row["is_recorded"]),
    )


def _flat(values: Floats) -> object:
    return np.asarray(values, np.float32).ravel()


def _shaped(values: object, columns: int) -> Floats:
    shaped: Floats = np.asarray(values, float).reshape(-1, columns)
    return shaped
