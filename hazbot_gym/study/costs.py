"""Computational costs of a study: time, memory and decisions, written after every session.

A killed session writes nothing; the seconds of its training runs remain in their folders.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

from hazbot_gym.utils import files

try:
    import resource
except ImportError:  # not on Windows
    resource = None  # type: ignore[assignment]


class Session(NamedTuple):
    """One process of a study from start to end."""

    command: str
    seconds: float
    prepared: int  # searches and training runs
    shards: int  # consecutive episodes of one policy in one scenario set
    decisions: int  # of all episodes of the study


class Training(NamedTuple):
    """Costs and results of a learner's training runs, averaged over its seeds."""

    name: str
    config: str
    seeds: int
    decisions: int  # of each run
    seconds: float
    validation_return: float


class Costs(NamedTuple):
    """Costs of a study: its sessions, and the training of its learners."""

    sessions: list[dict[str, object]]
    trainings: list[Training]


def note(path: Path, trainings: list[Training], session: Session | None) -> None:
    """Write training costs, and append a session if it did any work."""
    try:
        before = read(path)
    except files.Damaged:  # earlier costs are lost; not a reason to fail
        before = Costs([], [])
    sessions = before.sessions
    if session is not None:
        sessions = [*sessions, {**session._asdict(), "peak_memory_gb": peak_memory_gb()}]
    if Costs(sessions, trainings) != before:
        learned = [each._asdict() for each in trainings]
        files.write_json(path, {"sessions": sessions, "trainings": learned})


def read(path: Path) -> Costs:
    """Return the recorded costs; empty without a file."""
    if not path.exists():
        return Costs([], [])
    noted = files.read_json(path)
    learned = [Training(**each) for each in noted.get("trainings", ())]
    return Costs(list(noted["sessions"]), learned)


def peak_memory_gb() -> float | None:
    """Return the peak memory of this process or of its largest child."""
    if resource is None:
        return None
    both = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    peak = max(resource.getrusage(who).ru_maxrss for who in both)
    return peak / (1e9 if sys.platform == "darwin" else 1e6)  # bytes on macOS, kilobytes elsewhere
