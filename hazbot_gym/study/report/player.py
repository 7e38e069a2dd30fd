"""Encoding of replays for the page's player: whole centimetres, degrees and mm/s, deflated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.proxemics import INTIMATE_M, PERSONAL_M, SOCIAL_M
from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M, Floats
from hazbot_gym.evaluation.episode import VX, VY, X, Y
from hazbot_gym.study.replay_records import GAS_SERIES, Drive, Replay
from hazbot_gym.study.report.maps import positions, view
from hazbot_gym.study.report.packing import packed_json

NOBODY = 99_999  # empty slot, or person outside the view
SONAR_CM = 2  # unit of the sonar's readings


def pack(replays: Mapping[str, Sequence[Replay]]) -> str:
    """Return the replays of all sets as base64 of deflated JSON."""
    return packed_json(
        {
            "sets": {name: [_replay(each) for each in some] for name, some in replays.items()},
            "robot_cm": 100 * ROBOT_RADIUS_M,
            "person_cm": 100 * PERSON_RADIUS_M,
            "zones_cm": [100 * zone for zone in (SOCIAL_M, PERSONAL_M, INTIMATE_M)],
            "nobody": NOBODY,
            "sonar_cm": SONAR_CM,
        }
    )


def _replay(replay: Replay) -> dict[str, object]:
    path = replay.path
    low, high = view(path, [positions(episode) for episode in replay.runs.values()])
    return {
        "number": replay.number,
        "why": replay.why,
        "box": _whole(100 * np.concatenate([low, high])).tolist(),
        "walls": _whole(100 * replay.walls).tolist(),
        "path": _whole(100 * path).tolist(),
        "sonar": {
            "mount": round(100 * replay.sonar.mount_m, 1),
            "range": round(100 * replay.sonar.range_m / SONAR_CM),
            "axes": replay.sonar.axes_rad.round(4).tolist(),
            "half_cones": replay.sonar.half_cones_rad.round(4).tolist(),
        },
        **({"leak": _whole(100 * replay.leak).tolist()} if len(replay.leak) else {}),
        "runs": {
            policy: _run(episode, low - SOCIAL_M, high + SOCIAL_M)
            for policy, episode in replay.runs.items()
        },
    }


def _run(episode: Drive, low: Floats, high: Floats) -> dict[str, object]:
    """Pack an episode, with the people between two corners."""
    places = episode.people[..., (X, Y)]
    is_near = ((places > low) & (places < high)).all(axis=-1, keepdims=True)
    people = np.where(is_near, episode.people, np.nan)
    facing = np.degrees(np.arctan2(people[..., VY], people[..., VX]))
    columns = np.stack([100 * people[..., X], 100 * people[..., Y], facing], axis=-1)
    return {
        "dt_s": round(float(episode.time_s[1] - episode.time_s[0]), 6),
        "x": steps(100 * episode.pose[:, 0]),
        "y": steps(100 * episode.pose[:, 1]),
        "heading": steps(np.degrees(episode.pose[:, 2])),
        "speed": steps(1000 * episode.speed_mps),
        "earned": steps(100 * episode.earned),
        "sonar": [steps(100 / SONAR_CM * ranges_m) for ranges_m in episode.ranges_m.T],
        **{name: steps(100 * getattr(episode, name)) for name in GAS_SERIES if len(episode.alarm)},
        "contact": _whole(100 * episode.contact).tolist(),
        "people": [
            [steps(columns[:, slot, column]) for column in range(columns.shape[2])]
            for slot in range(columns.shape[1])
        ],
        "end": _end(episode),
    }


def _end(episode: Drive) -> str:
    """Return the outcome of an episode as text."""
    words = {
        "arrived": "arrived",
        "timeout": "timeout",
        "contact_wall": "touched a wall",
        "contact_person": f"contact caused by the {episode.contact_caused_by}",
    }
    end = f"{words[episode.outcome]} at {episode.time_s[-1]:.1f} s"
    return end if episode.is_recorded else f"{end}; differs from the measured episode"


def steps(values: Floats) -> list[int]:
    """Return the delta encoding of whole numbers, which deflates better."""
    changes: list[int] = np.diff(_whole(values), prepend=0).tolist()
    return changes


def _whole(values: Floats) -> npt.NDArray[np.int64]:
    return np.rint(np.nan_to_num(values, nan=NOBODY)).astype(np.int64)
