"""Top view of a scenario set: walls, the robot's path, and people's trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.episode import X, Y
from hazbot_gym.study.replay_records import Drive, Replay

MARGIN_M = 2.0  # least margin around the path
JUMP_M = 0.5  # longer than a step within a decision: another person took the slot
EVERY = 3  # instants between two points of a trajectory
MOST_WAYS = 12  # per episode; a recorded crowd would hide everything else
HUES = ("#c97a1d", "#a33a5c", "#3f8265")  # one per episode; more would overlap

Points = list[tuple[float, float]]


class Picture(NamedTuple):
    """Data of an SVG drawing, in metres with y downwards.

    Attributes:
        box: left, top, width, height of the view.
        walls: ends of each wall.
        path: the robot's, start to end.
        episodes: trajectories of the people in each episode, by color.
    """

    box: tuple[float, float, float, float]
    walls: list[Points]
    path: Points
    episodes: dict[str, list[Points]]


def picture(replays: Sequence[Replay], policy: str) -> Picture:
    """Return the picture of a set: its first episode's place, and people in the first episodes."""
    first = replays[0]
    episodes = [replay.runs[policy] for replay in replays[: len(HUES)]]
    low, high = view(first.path, [positions(episode) for episode in episodes])
    return Picture(
        box=(*_round(low[0], -high[1]), *_round(*(high - low))),
        walls=[_svg(wall.reshape(2, 2)) for wall in first.walls],
        path=_svg(first.path),
        episodes={
            hue: [_svg(way) for way in _some(ways(episode))]
            for hue, episode in zip(HUES, episodes, strict=False)
        },
    )


def view(path: Floats, people: Sequence[Floats]) -> tuple[Floats, Floats]:
    """Return the lower left and upper right corner of the view, (2,) each [m].

    The view is the path with a margin. If it is long and narrow, it grows sideways to an aspect
    ratio of at most 2, as far as there are people.

    Args:
        path: (n, 2) points.
        people: positions (m, 2) of people.
    """
    low, high = path.min(axis=0) - MARGIN_M, path.max(axis=0) + MARGIN_M
    room = np.maximum((high - low).max() / 2.0 - (high - low), 0.0) / 2.0
    seen = np.concatenate([path, *people])
    return (
        np.minimum(low, np.maximum(low - room, seen.min(axis=0) - 0.5)),
        np.maximum(high, np.minimum(high + room, seen.max(axis=0) + 0.5)),
    )


def ways(episode: Drive) -> list[Floats]:
    """Return the trajectory (n, 2) of each person of an episode, split at impossible steps."""
    found = []
    for slot in range(episode.people.shape[1]):
        points = episode.people[:, slot, (X, Y)]
        breaks = ~(np.hypot(*np.diff(points, axis=0).T) < JUMP_M)  # also if absent
        for part in np.split(points, np.nonzero(breaks)[0] + 1):
            there = part[np.isfinite(part[:, 0])]
            if len(there) > 1:
                found.append(np.concatenate([there[:-1:EVERY], there[-1:]]))
    return found


def _some(found: list[Floats]) -> list[Floats]:
    """Return an even subset of the trajectories, small enough to be legible."""
    return found[:: -(-len(found) // MOST_WAYS) or 1]


def positions(episode: Drive) -> Floats:
    """Return all positions of people, (m, 2) [m]."""
    points = episode.people[..., (X, Y)].reshape(-1, 2)
    return points[np.isfinite(points[:, 0])]


def _svg(points: Floats) -> Points:
    return [_round(x, -y) for x, y in points]


def _round(x: float, y: float) -> tuple[float, float]:
    return round(float(x), 2), round(float(y), 2)
