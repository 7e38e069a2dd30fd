"""Recordings of a file or a folder: search for tables, and reading."""

from __future__ import annotations

import itertools
import os
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hazbot_gym.errors import DoubtfulRecording, InvalidInput
from hazbot_gym.task.track_checks import doubts
from hazbot_gym.task.track_description import Source, read_description
from hazbot_gym.task.track_files import AS_FOUND, Options, check_options, read_tracks
from hazbot_gym.task.track_formats import ENDINGS, UnknownFormat, looks_like_table
from hazbot_gym.task.track_formats.encounters import is_encounters, read_encounters
from hazbot_gym.task.tracks import Recording

MOST_FOLDERS = 10_000  # more files mean a whole disk instead of a folder of recordings
_SAME_M = 0.01  # positions this near are the same


class Found(NamedTuple):
    """Contents of a file or folder.

    Attributes:
        recordings: Recordings with unique names.
        doubts: One line per failed plausibility check.
        faults: A line for each file that cannot be read.
    """

    recordings: list[Recording]
    doubts: list[str]
    faults: list[str]


def load_tracks(path: str | Path) -> list[Recording]:
    """Return the recordings of a file or folder; doubts about them are warnings.

    Encounters with a robot are left out, with a warning, if there are other recordings, since their
    places are the paths of the recorded robots.

    Raises:
        InvalidInput: there is no recording, one cannot be read, or two are the same.
    """
    found = read_all(path)
    faults = found.faults + copies(found.recordings)
    if faults:
        raise InvalidInput("; ".join(faults))
    for doubt in found.doubts:
        warnings.warn(doubt, DoubtfulRecording, stacklevel=2)
    others = [recording for recording in found.recordings if recording.robot is None]
    left_out = len(found.recordings) - len(others)
    if others and left_out:
        doubt = f"not used: {left_out} encounters with a robot; give their file alone to use them"
        warnings.warn(doubt, DoubtfulRecording, stacklevel=2)
    return others or found.recordings


def read_all(path: str | Path, options: Options = AS_FOUND) -> Found:
    """Read every recording of a file or folder.

    In a folder, a file of an unknown format is no recording; alone, it is a fault.

    Raises:
        InvalidInput: there is no such file or folder, or no recording in it.
    """
    check_options(options)
    path = Path(path)
    files = find_recordings(path)
    found: dict[Path, Recording] = {}
    unknown, faults = [], []
    met: list[Recording] = []
    for file in files:
        try:
            if is_encounters(file):
                met += read_encounters(file)
            else:
                found[file] = read_tracks(file, **options._asdict())
        except UnknownFormat as fault:
            unknown.append(str(fault))
        except InvalidInput as fault:
            faults.append(str(fault))
    if not found and not met and not faults:
        return Found([], [], unknown)
    recordings = _with_own_names(found, path) + met
    signs = [f"{each.name}: {doubt}" for each in recordings for doubt in doubts(each)]
    return Found(recordings, [f"not read: {line}" for line in unknown] + signs, faults)


def find_recordings(path: str | Path) -> list[Path]:
    """Return the tables below a folder, sorted; a file is returned unchanged.

    Files with the ending of a table are tables, except texts without rows of numbers, and those
    that a description names as the original of a table.

    Raises:
        InvalidInput: there is no such file or folder, or no table in it.
    """
    path = Path(path)
    if not os.path.exists(path):  # False if Path.exists raises
        raise InvalidInput(f"tracks: given {str(path)!r}, there is no such file or folder")
    if not os.path.isdir(path):
        if not os.path.isfile(path):
            raise InvalidInput(f"tracks: given {str(path)!r}, which is neither a file nor a folder")
        return [path]
    files = sorted(_files(path))
    tables = [file for file in files if file.suffix.lower() in ENDINGS and os.path.isfile(file)]
    originals = {original for file in tables for original in _originals(file, path)}
    tables = [file for file in tables if file.resolve() not in originals]
    found = [file for file in tables if file.suffix.lower() != ".txt" or looks_like_table(file)]
    if not found:
        raise InvalidInput(f"tracks: no recordings ({', '.join(ENDINGS)}) in {path}")
    return found


def copies(recordings: list[Recording]) -> list[str]:
    """Return a line for each pair of recordings of the same people."""
    return [
        f"{b.name} holds the same people as {a.name}: remove one, or name it in the JSON of the "
        "other as source.original_file"
        for a, b in itertools.combinations(recordings, 2)
        if _is_same(a, b)
    ]


def _is_same(a: Recording, b: Recording) -> bool:
    return (
        a.people == b.people
        and np.array_equal(a.first_steps, b.first_steps)
        and np.array_equal(a.lengths, b.lengths)
        and bool(np.allclose(a.positions, b.positions, atol=_SAME_M, rtol=0.0))
    )


def _files(folder: Path) -> Iterator[Path]:
    """Return all files below a folder, through links as well, each folder once."""
    seen = set()
    for name, folders, files in os.walk(folder, onerror=_refuse, followlinks=True):
        real = os.path.realpath(name)
        if real in seen:
            folders.clear()
            continue
        seen.add(real)
        if len(seen) > MOST_FOLDERS:
            raise InvalidInput(
                f"tracks: more than {MOST_FOLDERS} folders are below {folder}, through links as "
                "well; give one nearer to the recordings"
            )
        yield from (Path(name, file) for file in files)


def _refuse(error: OSError) -> None:
    """Raise for a folder that cannot be listed, since it may hold recordings."""
    if not isinstance(error, FileNotFoundError):  # removed meanwhile
        raise InvalidInput(f"tracks: cannot read {error.filename} ({error.strerror})")


def _originals(table: Path, top: Path) -> Iterator[Path]:
    """Yield candidate paths of a table's original, from its folder up to the top."""
    try:
        source = read_description(table.with_suffix(".json")).source
    except InvalidInput:  # reported when the table is read
        return
    if not isinstance(source, Source) or not source.original_file:
        return
    for folder in (table.parent, *table.parent.parents):
        original = (folder / source.original_file).resolve()
        if original != table.resolve():
            yield original
        if folder == top:
            return


def _with_own_names(found: dict[Path, Recording], top: Path) -> list[Recording]:
    """Return the recordings with unique names: duplicates are named by their path in the folder."""
    names = [recording.name for recording in found.values()]
    return [
        recording
        if names.count(recording.name) == 1
        else replace(recording, name=file.relative_to(top).as_posix())
        for file, recording in found.items()
    ]
