from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from hazbot_gym.utils import provenance


def test_a_digest_changes_with_every_name_and_every_content(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "a.csv").write_text("1")
    digests = {provenance.digest(tmp_path)}
    (tmp_path / "deep" / "a.csv").write_text("2")
    digests.add(provenance.digest(tmp_path))
    (tmp_path / "deep" / "a.csv").rename(tmp_path / "deep" / "b.csv")
    digests.add(provenance.digest(tmp_path))
    assert len(digests) == 3
    assert provenance.digest(tmp_path / "deep" / "b.csv") not in digests


def test_a_stamp_covers_code_versions_and_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tracks.csv").write_text("frame,id,x,y\n")
    stamps = {provenance.stamp(), provenance.stamp(tmp_path)}
    monkeypatch.setattr(provenance, "versions", lambda: {"numpy": "0.0"})
    stamps.add(provenance.stamp())
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path)
    stamps.add(provenance.stamp())
    assert len(stamps) == 4
    assert provenance.stamp() == provenance.stamp()


def test_an_install_outside_a_checkout_has_no_commit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path / "hazbot_gym")
    assert provenance.commit() is None


def git(checkout: Path, *arguments: str) -> str:
    who = ("-c", "user.name=a", "-c", "user.email=a@b.c")
    command = ["git", "-C", str(checkout), *who, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def test_an_edited_checkout_is_said_to_be_and_its_index_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path / "hazbot_gym")
    (tmp_path / "code.py").write_text("a = 1")
    git(tmp_path, "init")
    git(tmp_path, "add", "code.py")
    git(tmp_path, "commit", "-m", "first")
    head = git(tmp_path, "rev-parse", "HEAD")
    os.utime(tmp_path / "code.py", (0, 0))  # git would write the new time into its index
    index = (tmp_path / ".git" / "index").read_bytes()
    assert provenance.commit() == head
    assert (tmp_path / ".git" / "index").read_bytes() == index
    (tmp_path / "code.py").write_text("a = 2")
    assert provenance.commit() == f"{head}-dirty"


def test_versions_name_what_is_installed() -> None:
    versions = provenance.versions()
    assert versions["python"].startswith("3.")
    assert {"numpy", "gymnasium", "numba", "pymunk"} <= set(versions)


def test_the_machine_is_described() -> None:
    assert provenance.machine()["processor"]
