"""Atomic file writing, and records with checksums.

Each file is written under a temporary name and then renamed. A record contains a checksum
(``utils/checksum.py``), which is verified on reading.
"""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils.checksum import BLANK, is_whole, seal
from hazbot_gym.utils.json_object import JsonObject

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

LONGEST = 200  # bytes of a name; file systems allow 255, including a temporary suffix
CHECKSUM = "checksum"  # key of a JSON record, hidden from readers


class Damaged(InvalidInput):
    """A record is damaged: truncated, changed, or of a version without checksums."""

    def __init__(self, path: Path) -> None:
        super().__init__(
            f"{str(path)!r} is damaged, or was edited: its checksum is not that of its content"
        )


def write_atomically(path: Path, write: Callable[[Path], None]) -> None:
    """Write a file atomically: ``write`` fills a temporary file, which is renamed to ``path``.

    Raises:
        InvalidInput: The file cannot be written: no space, no permission, no folder.
    """
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside.touch(exist_ok=False)
        write(beside)
        beside.replace(path)
    except OSError as error:
        reason = error.strerror or error
        raise InvalidInput(f"out: cannot write {str(path)!r}: {reason}") from error
    finally:
        with contextlib.suppress(OSError):
            beside.unlink()


def check_writable(path: Path, field: str = "out") -> None:
    """Raise before any work if a file cannot be written; leave nothing behind.

    Args:
        path: Path of the file; missing folders would be created.
        field: Name of the user's option.

    Raises:
        InvalidInput: The path is a folder or not writable.
    """
    if os.path.isdir(path):  # which rejects names that are too long
        raise InvalidInput(f"{field}: given {str(path)!r}, which is a folder; give a file")
    try:
        nearest = next(folder for folder in path.absolute().parents if folder.exists())
        with tempfile.TemporaryFile(dir=nearest):
            pass
    except OSError as error:
        raise InvalidInput(f"{field}: cannot write {str(path)!r}: {error.strerror}") from error


def write_bytes(path: Path, data: bytes) -> None:
    """Write bytes atomically."""
    write_atomically(path, lambda beside: _write(beside, data))


def write_text(path: Path, text: str) -> None:
    """Write text as UTF-8; invalid characters (from file names) are escaped."""
    write_bytes(path, text.encode(errors="backslashreplace"))


def write_json(path: Path, content: Mapping[str, object], *, is_sorted: bool = True) -> None:
    """Write a JSON record.

    Args:
        path: Of the file.
        content: Values for JSON, with ``None`` for numbers that are not finite.
        is_sorted: Whether to sort keys.
    """
    sealed = {**content, CHECKSUM: BLANK}
    text = json.dumps(sealed, indent=2, sort_keys=is_sorted, allow_nan=False, ensure_ascii=False)
    write_bytes(path, seal(f"{text}\n".encode(errors="backslashreplace")))


def read_json(path: Path) -> JsonObject:
    """Read and verify a JSON record.

    Raises:
        Damaged: Its checksum is missing or wrong.
        InvalidInput: The file cannot be read.
    """
    data = read_sealed(path)
    try:
        content = json.loads(data)
    except (ValueError, RecursionError) as error:  # foreign file with a valid checksum
        raise Damaged(path) from error
    if not isinstance(content, dict) or CHECKSUM not in content:
        raise Damaged(path)
    del content[CHECKSUM]
    return content


def read_sealed(path: Path) -> bytes:
    """Return the bytes of a file that has a checksum inside; raises as ``read_json``."""
    if path.exists() and not path.is_file():  # a pipe or a device may be endless
        raise InvalidInput(f"cannot read {str(path)!r}: it is no file")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read {str(path)!r}: {error.strerror}") from error
    if not is_whole(data):
        raise Damaged(path)
    return data


@contextlib.contextmanager
def sole_use(folder: Path) -> Iterator[None]:
    """Context manager: lock a folder for this process; create it if missing.

    No lock file is written; on systems without folder locks this does nothing.

    Raises:
        InvalidInput: Another process holds the lock, or the folder cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise InvalidInput(f"out: cannot write {str(folder)!r}: {error.strerror}") from error
    try:
        with contextlib.suppress(OSError):  # not on every network file system
            _lock(handle, folder)
        yield
    finally:
        os.close(handle)


def _lock(handle: int, folder: Path) -> None:
    if fcntl is None:
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InvalidInput(
            f"out: another run is at work in {str(folder)!r}; wait for its end, or give another "
            "--out"
        ) from None


def file_name(text: str) -> str:
    """Return a text as file name, with ``_`` for all but letters, digits, ``-`` and ``.``."""
    return "".join(letter if letter.isalnum() or letter in "-." else "_" for letter in text)


def owner(folder: Path, manifest: str, kind: str) -> str | None:
    """Return the study or run that owns a folder; None if it is new or empty.

    Args:
        folder: Folder of results.
        manifest: Name of its file that names the owner.
        kind: Kind of the owner, ``study`` or ``run``: the key in that file.

    Raises:
        InvalidInput: It is a file, not writable, or holds files without an owner.
    """
    if os.path.isfile(folder):  # which rejects names that are too long
        raise InvalidInput(
            f"out: given {str(folder)!r}, which is a file; give a new or empty folder"
        )
    check_writable(folder / manifest)
    if not folder.exists():
        return None
    if not any(folder.iterdir()):
        return None
    try:
        found: str = read_json(folder / manifest)[kind]
    except (InvalidInput, KeyError) as error:
        raise InvalidInput(
            f"out: {str(folder)!r} holds files that are no {kind}'s, or its {manifest} is damaged; "
            "give a new or empty folder"
        ) from error
    return found


def remove_partial(folder: Path) -> None:
    """Remove partial files of a killed run from a folder."""
    for leftover in folder.glob(".*.tmp"):
        leftover.unlink(missing_ok=True)


def _write(path: Path, data: bytes) -> None:
    path.write_bytes(data)
