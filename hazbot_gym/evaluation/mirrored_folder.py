"""Folder of one machine that a function on another machine works in.

The function works in a copy. What it writes is sent back every few seconds and at the end, so that
a run that loses its machine resumes from its last checkpoint.
"""

from __future__ import annotations

import contextlib
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from hazbot_gym.utils import files

SEND_EVERY_S = 5.0

Contents = dict[str, bytes]  # of files, by their path in the folder


class Changes(NamedTuple):
    """Changes of a folder."""

    written: Contents
    names: frozenset[str]  # of all its files


def read(folder: Path) -> Contents:
    """Return the contents of a folder, which may be missing."""
    return {name: (folder / name).read_bytes() for name in _names(folder)}


def apply(folder: Path, changes: Changes) -> None:
    """Repeat changes in a folder."""
    # Checkpoints last, as in the original: each then finds the policy that it names.
    for name in sorted(changes.written, reverse=True):
        files.write_bytes(folder / name, changes.written[name])
    for name in set(_names(folder)) - changes.names:
        (folder / name).unlink()


@contextlib.contextmanager
def working_copy(name: str, contents: Contents, send: Callable[[Changes], None]) -> Iterator[Path]:
    """Context manager of a temporary folder; ``send`` is called with its changes."""
    with tempfile.TemporaryDirectory(prefix="hazbot-folder-") as temporary:
        folder = Path(temporary, name)
        apply(folder, Changes(contents, frozenset(contents)))
        changes, is_over = _Watch(folder), threading.Event()

        def keep_sending() -> None:
            while not is_over.wait(SEND_EVERY_S):
                send(changes.since_last())

        sender = threading.Thread(target=keep_sending, daemon=True)
        sender.start()
        try:
            yield folder
        finally:
            is_over.set()
            sender.join()
            send(changes.since_last())


class _Watch:
    """Watch of a folder's files."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._seen = self._states()

    def since_last(self) -> Changes:
        """Return the changes since the last call."""
        before, self._seen = self._seen, self._states()
        changed = [name for name, state in self._seen.items() if state != before.get(name)]
        written = {}
        for name in sorted(changed):
            with contextlib.suppress(FileNotFoundError):  # removed meanwhile
                written[name] = (self._folder / name).read_bytes()
        return Changes(written, frozenset(self._seen))

    def _states(self) -> dict[str, tuple[int, int]]:
        found = {}
        for name in _names(self._folder):
            with contextlib.suppress(FileNotFoundError):
                about = (self._folder / name).stat()
                found[name] = (about.st_size, about.st_mtime_ns)
        return found


def _names(folder: Path) -> list[str]:
    """Return the paths of a folder's files, except of those that are being written."""
    found = [path for path in folder.rglob("*") if path.is_file()]
    return [
        path.relative_to(folder).as_posix()
        for path in found
        if not (path.name.startswith(".") and path.suffix == ".tmp")
    ]
