from __future__ import annotations

import os
from pathlib import Path

import pytest

from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.utils import processors


@pytest.fixture(autouse=True)
def no_groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Give a machine of eight processors, all allowed, without control groups."""
    monkeypatch.setattr(processors, "MEMBERSHIP", tmp_path / "membership")
    monkeypatch.setattr(processors, "MOUNT", tmp_path / "mount")
    monkeypatch.setattr(os, "cpu_count", lambda: 8)
    allow(monkeypatch, 8)


def allow(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    monkeypatch.setattr(os, "process_cpu_count", lambda: count, raising=False)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(count)), raising=False)


def put_in_group(folder: Path, membership: str, files: dict[str, str]) -> None:
    (folder / "membership").write_text(membership)
    for name, text in files.items():
        path = folder / "mount" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def test_processors_outside_the_affinity_mask_do_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    assert processors.usable() == 8
    allow(monkeypatch, 1)
    assert processors.usable() == 1


@pytest.mark.parametrize(
    ("membership", "files", "count"),
    [
        ("0::/\n", {"cpu.max": "150000 100000\n"}, 2),
        ("0::/\n", {"cpu.max": "1000 100000\n"}, 1),
        ("0::/\n", {"cpu.max": "max 100000\n"}, 8),
        ("0::/job/step\n", {"job/cpu.max": "300000 100000", "job/step/cpu.max": "max 1"}, 3),
        ("0::/host/docker/17\n", {"cpu.max": "200000 100000"}, 2),
        (
            "4:memory:/x\n2:cpu,cpuacct:/x\n",
            {
                "cpu,cpuacct/x/cpu.cfs_quota_us": "400000\n",
                "cpu,cpuacct/x/cpu.cfs_period_us": "100000\n",
            },
            4,
        ),
        (
            "2:cpu:/\n",
            {"cpu/cpu.cfs_quota_us": "-1\n", "cpu/cpu.cfs_period_us": "100000\n"},
            8,
        ),
        ("0::/\n", {"cpu.max": "no quota at all\n"}, 8),
        ("0::/\n", {"cpu.max": "9900000 100000\n"}, 8),
    ],
)
def test_quotas_of_control_groups_limit_the_count(
    tmp_path: Path, membership: str, files: dict[str, str], count: int
) -> None:
    put_in_group(tmp_path, membership, files)

    assert processors.usable() == count


def test_worlds_are_stepped_by_as_many_threads_as_there_are_usable_processors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    allow(monkeypatch, 3)

    assert CorridorVectorEnv(8)._thread_count == 3
