"""What a study took: time, memory and decisions, noted at the end of every session.

A session that is killed notes nothing; of its training runs the folders keep the seconds.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, NamedTuple

from hazbot_gym.study import files

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


def note(path: Path, session: Session) -> None:
    """Add a session to those noted before."""
    sessions = [*read(path), {**session._asdict(), "peak_memory_gb": peak_memory_gb()}]
    files.write_json(path, {"sessions": sessions})


def read(path: Path) -> list[dict[str, Any]]:
    """Return the sessions that are noted; none if there is no such file."""
    if not path.exists():
        return []
    return list(files.read_json(path)["sessions"])


def peak_memory_gb() -> float | None:
    """Return the most memory that this process, or the largest of its children, ever held."""
    if resource is None:
        return None
    both = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    peak = max(resource.getrusage(who).ru_maxrss for who in both)
    return peak / (1e9 if sys.platform == "darwin" else 1e6)  # bytes there, kilobytes elsewhere
