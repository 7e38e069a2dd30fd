"""Number of processors that this process may use, which can be fewer than the machine has.

Two limits are heeded on Linux: the CPU affinity (``taskset``, job schedulers) and the CPU quota of
the control groups that the process is in (containers; ``cpu.max`` of version 2,
``cpu.cfs_quota_us`` of version 1), rounded up to a whole processor.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

MEMBERSHIP, MOUNT = Path("/proc/self/cgroup"), Path("/sys/fs/cgroup")


def usable() -> int:
    """Return the number of processors available to this process, at least 1."""
    limits = (math.ceil(quota) for quota in _quotas(MEMBERSHIP, MOUNT))
    return max(1, min([_allowed(), *limits]))


def _allowed() -> int:
    """Return the number of processors in the affinity mask; of the machine where there is none."""
    if hasattr(os, "process_cpu_count"):  # Python 3.13; also heeds PYTHON_CPU_COUNT
        return os.process_cpu_count() or 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _quotas(membership: Path, mount: Path) -> Iterator[float]:
    """Yield the quota of each control group of this process and of the groups above, if limited."""
    try:
        lines = membership.read_text(encoding="utf-8").splitlines()
    except OSError:  # no Linux
        return
    for line in lines:
        _, controllers, group = line.split(":", 2)
        if controllers and "cpu" not in controllers.split(","):
            continue
        root = mount / controllers if controllers else mount
        inside = PurePosixPath(group.lstrip("/"))
        for above in (inside, *inside.parents):
            yield from _quota(root / above)


def _quota(folder: Path) -> Iterator[float]:
    try:
        if (folder / "cpu.max").exists():
            quota, period = (folder / "cpu.max").read_text().split()
        else:
            quota, period = (
                (folder / f"cpu.cfs_{part}_us").read_text().strip() for part in ("quota", "period")
            )
    except (OSError, ValueError):
        return
    if quota not in ("max", "-1"):
        yield int(quota) / int(period)
