"""What a study took: time, memory and decisions, noted at the end of every session.

A session that is killed notes nothing; of its training runs the folders keep the seconds.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, NamedTuple

from hazbot_gym.utils import files

try:
    import resource
except ImportError:  # not on Windows
    resource = None  # type: ignore[assignment]


class Session(NamedTuple):
    """A run of a study from its start to its end."""

    command: str
    seconds: float
    prepared: int  # searches and training runs
    shards: int  # blocks of episodes
    decisions: int  # of all episodes of the study


class Training(NamedTuple):
    """What the training runs of a learner took and came to, on average over its seeds."""

    name: str
    config: str
    seeds: int
    decisions: int  # of each run
    seconds: float
    validation_return: float


class Costs(NamedTuple):
    """What a study took: its sessions as they were noted, and the training of its learners."""

    sessions: list[dict[str, Any]]
    trainings: list[Training]


def note(path: Path, trainings: list[Training], session: Session | None) -> None:
    """Note trainings, and add a session to those before, if there was something to do in it."""
    try:
        before = read(path)
    except files.Damaged:  # what it took before is lost, which is no reason to end here
        before = Costs([], [])
    sessions = before.sessions
    if session is not None:
        sessions = [*sessions, {**session._asdict(), "peak_memory_gb": peak_memory_gb()}]
    if Costs(sessions, trainings) != before:
        learned = [each._asdict() for each in trainings]
        files.write_json(path, {"sessions": sessions, "trainings": learned})


def read(path: Path) -> Costs:
    """Return what is noted; nothing if there is no such file."""
    if not path.exists():
        return Costs([], [])
    noted = files.read_json(path)
    learned = [Training(**each) for each in noted.get("trainings", ())]
    return Costs(list(noted["sessions"]), learned)


def peak_memory_gb() -> float | None:
    """Return the most memory that this process, or the largest of its children, ever held."""
    if resource is None:
        return None
    both = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    peak = max(resource.getrusage(who).ru_maxrss for who in both)
    return peak / (1e9 if sys.platform == "darwin" else 1e6)  # bytes there, kilobytes elsewhere
