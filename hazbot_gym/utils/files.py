"""Files that are whole or absent, never half-written, and records that notice damage.

Each file is filled under another name first. A record has a checksum inside
(``utils/checksum.py``), which is compared before anything of it is used.
"""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils.checksum import BLANK, is_whole, seal

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

LONGEST = 200  # bytes of a name; file systems allow 255, and something is added to it
CHECKSUM = "checksum"  # key of a JSON record, which readers do not see


class Damaged(InvalidInput):
    """A record is not what was written: cut off, changed, or of a version without checksums."""

    def __init__(self, path: Path) -> None:
        super().__init__(
            f"{str(path)!r} is damaged, or was edited: its checksum is not that of its content"
        )


def write_atomically(path: Path, write: Callable[[Path], None]) -> None:
    """Let ``write`` fill a file beside ``path``, then rename it: readers see all of it or none.

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
    """Complain before any work if a file could not be written in the end; leave nothing behind.

    Args:
        path: Of the file; folders that are not there yet would be made.
        field: Name of what the user gave.

    Raises:
        InvalidInput: It is a folder, or a place where nothing can be written.
    """
    if os.path.isdir(path):  # which takes names that are too long
        raise InvalidInput(f"{field}: given {str(path)!r}, which is a folder; give a file")
    try:
        nearest = next(folder for folder in path.absolute().parents if folder.exists())
        with tempfile.TemporaryFile(dir=nearest):
            pass
    except OSError as error:
        raise InvalidInput(f"{field}: cannot write {str(path)!r}: {error.strerror}") from error


def write_bytes(path: Path, data: bytes) -> None:
    """Write bytes as they are."""
    write_atomically(path, lambda beside: _write(beside, data))


def write_text(path: Path, text: str) -> None:
    """Write text as UTF-8; what is no letter of it (from the name of a file) as an escape."""
    write_bytes(path, text.encode(errors="backslashreplace"))


def write_json(path: Path, content: Mapping[str, Any], *, is_sorted: bool = True) -> None:
    """Write a JSON record.

    Args:
        path: Of the file.
        content: A number that is not finite must have become ``None`` before.
        is_sorted: Whether keys are sorted, or stay in their order.
    """
    sealed = {**content, CHECKSUM: BLANK}
    text = json.dumps(sealed, indent=2, sort_keys=is_sorted, allow_nan=False, ensure_ascii=False)
    write_bytes(path, seal(f"{text}\n".encode(errors="backslashreplace")))


def read_json(path: Path) -> dict[str, Any]:
    """Return a JSON record as it was written.

    Raises:
        Damaged: Its checksum is absent, or not that of its content.
        InvalidInput: It cannot be read.
    """
    data = read_sealed(path)
    try:
        content = json.loads(data)
    except (ValueError, RecursionError) as error:  # whoever made it has computed a checksum
        raise Damaged(path) from error
    if not isinstance(content, dict) or CHECKSUM not in content:
        raise Damaged(path)
    del content[CHECKSUM]
    return content


def read_sealed(path: Path) -> bytes:
    """Return the bytes of a file that has a checksum inside; raises as ``read_json``."""
    if path.exists() and not path.is_file():  # a pipe or a device may have no end
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
    """Keep a folder, made if it is not there, to this process.

    Nothing is written for it; where a system has no locks for folders, nothing is kept.

    Raises:
        InvalidInput: Another process keeps it, or it cannot be made.
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
    """Return text as a name of a file: all but letters, digits, ``-`` and ``.`` becomes ``_``."""
    return "".join(letter if letter.isalnum() or letter in "-." else "_" for letter in text)


def owner(folder: Path, manifest: str, kind: str) -> str | None:
    """Return which study or run a folder belongs to; None if it is new or empty.

    Args:
        folder: That results are to go to.
        manifest: Name of the file in it that says whose it is.
        kind: What the owner is called, ``study`` or ``run``: the key in that file.

    Raises:
        InvalidInput: It is a file, cannot be written, or holds files of nobody.
    """
    if os.path.isfile(folder):  # which takes names that are too long
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


def sweep(folder: Path) -> None:
    """Remove what a killed run left half-written in a folder."""
    for leftover in folder.glob(".*.tmp"):
        leftover.unlink(missing_ok=True)


def _write(path: Path, data: bytes) -> None:
    path.write_bytes(data)
