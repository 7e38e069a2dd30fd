"""Files that are whole or absent, never half-written: each is filled under another name first."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hazbot_gym.errors import InvalidInput


def write_atomically(path: Path, write: Callable[[Path], None]) -> None:
    """Let ``write`` fill a file beside ``path``, then rename it: readers see all of it or none."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".tmp")
    except OSError as error:
        raise InvalidInput(f"out: cannot write {str(path)!r}: {error.strerror}") from error
    os.close(handle)
    beside = Path(name)
    try:
        write(beside)
        beside.chmod(0o644)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write JSON with sorted keys; a number that is not finite must have become ``None`` before."""
    text = json.dumps(content, indent=2, sort_keys=True, allow_nan=False, ensure_ascii=False)
    write_text(path, text + "\n")


def write_text(path: Path, text: str) -> None:
    """Write text as UTF-8."""
    write_atomically(path, lambda beside: _write_text(beside, text))


def owner(folder: Path, manifest: str, kind: str) -> str | None:
    """Return which study or run a folder belongs to; None if it is new or empty.

    Args:
        folder: That results are to go to.
        manifest: Name of the file in it that says whose it is.
        kind: What the owner is called, ``study`` or ``run``: the key in that file.

    Raises:
        InvalidInput: It is a file, or holds files of nobody.
    """
    if not folder.exists():
        return None
    if not folder.is_dir():
        raise InvalidInput(
            f"out: given {str(folder)!r}, which is a file; give a new or empty folder"
        )
    if not any(folder.iterdir()):
        return None
    try:
        found = json.loads((folder / manifest).read_text(encoding="utf-8"))[kind]
    except (OSError, ValueError, KeyError, TypeError):
        found = None
    if not isinstance(found, str):
        raise InvalidInput(
            f"out: {str(folder)!r} holds files that are no {kind}'s; give a new or empty folder"
        )
    return found


def sweep(folder: Path) -> None:
    """Remove what a killed run left half-written in a folder."""
    for leftover in folder.glob(".*.tmp"):
        leftover.unlink(missing_ok=True)


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
