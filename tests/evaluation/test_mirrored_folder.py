from __future__ import annotations

import threading
from pathlib import Path

import pytest

from hazbot_gym.evaluation import mirrored_folder
from hazbot_gym.evaluation.mirrored_folder import Changes, apply, read, working_copy


@pytest.fixture
def original(tmp_path: Path) -> Path:
    folder = tmp_path / "run"
    (folder / "checkpoints").mkdir(parents=True)
    (folder / "checkpoints" / "1.pt").write_bytes(b"first")
    (folder / "policy.npz").write_bytes(b"policy")
    return folder


def test_what_is_written_edited_or_removed_in_a_copy_is_so_in_the_original(original: Path) -> None:
    with working_copy("run", read(original), lambda changes: apply(original, changes)) as copy:
        assert read(copy) == read(original)
        (copy / "checkpoints" / "1.pt").unlink()
        (copy / "checkpoints" / "2.pt").write_bytes(b"second")
        (copy / "policy.npz").write_bytes(b"better policy")
        (copy / ".result.json.0.tmp").write_bytes(b"half a fi")
    expected = {"checkpoints/2.pt": b"second", "policy.npz": b"better policy"}
    assert read(original) == expected
    assert not copy.exists()


def test_only_what_changed_is_sent(original: Path) -> None:
    sent: list[Changes] = []
    with working_copy("run", read(original), sent.append) as copy:
        (copy / "manifest.json").write_bytes(b"{}")
    (changes,) = sent
    assert changes.written == {"manifest.json": b"{}"}


def test_changes_are_sent_before_the_end_and_after_an_error(
    original: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mirrored_folder, "SEND_EVERY_S", 0.01)
    arrived = threading.Event()

    def send(changes: Changes) -> None:
        apply(original, changes)
        if (original / "checkpoints" / "2.pt").exists():
            arrived.set()

    with pytest.raises(RuntimeError, match="lost"), working_copy("run", {}, send) as copy:  # noqa: PT012
        (copy / "checkpoints").mkdir(parents=True)
        (copy / "checkpoints" / "2.pt").write_bytes(b"second")
        assert arrived.wait(10)
        (copy / "checkpoints" / "3.pt").write_bytes(b"third")
        raise RuntimeError("lost")
    assert read(original) == {"checkpoints/2.pt": b"second", "checkpoints/3.pt": b"third"}
