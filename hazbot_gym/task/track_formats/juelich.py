"""Hdf5 of the Juelich archive: a dataset ``trajectory`` with fields ``id, frame, x, y``.

The dataset has an attribute ``fps``, the file an attribute ``wkt_geometry``, the walkable area,
whose edges become walls. Positions are in metres. https://ped.fz-juelich.de/da/doku.php?id=info
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.task.track_formats.table import (
    MOST_BYTES,
    NO_WALLS,
    Table,
    UnknownFormat,
    sorted_sightings,
)
from hazbot_gym.task.track_formats.walkable import walls_of

if TYPE_CHECKING:
    import h5py

_FIELDS = ("id", "frame", "x", "y")


def read(path: Path) -> Table:
    """Read a file.

    Raises:
        UnknownFormat: the dataset or a field is missing.
        InvalidInput: the file is damaged or too large.
        MissingExtra: h5py is not installed, or shapely for the walkable area.
    """
    try:
        import h5py
    except ImportError as error:
        raise MissingExtra("h5py", "tracks") from error
    try:
        with h5py.File(path, "r") as file:
            return _read(path.name, file)
    except (OSError, RuntimeError, KeyError) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InvalidInput(f"{path.name}: is not a usable hdf5 file ({first})") from None


def _read(name: str, file: h5py.File) -> Table:
    found = file.get("trajectory")
    fields = getattr(found, "dtype", np.dtype("V")).names or ()
    if not set(_FIELDS) <= set(fields):
        raise UnknownFormat(name, "hdf5 without a dataset trajectory(id, frame, x, y)")
    if found.ndim != 1 or found.size * found.dtype.itemsize > MOST_BYTES:
        raise InvalidInput(f"{name}: trajectory must have one dimension and at most 256 MiB")
    try:
        columns = [np.asarray(found[field], dtype=np.float64) for field in _FIELDS]
        fps = float(np.asarray(found.attrs["fps"]).item()) if "fps" in found.attrs else None
    except (TypeError, ValueError):
        raise InvalidInput(f"{name}: trajectory: a value is not a number") from None
    area = file.attrs.get("wkt_geometry")
    text = area.decode("utf-8", "replace") if isinstance(area, bytes) else area
    ids, frames, x, y = columns
    return Table(
        *sorted_sightings(name, ids, frames, np.column_stack([x, y])),
        form="Juelich hdf5",
        fps=fps,
        fps_from="attribute fps" if fps else "",
        unit="m",
        unit_from="format",
        walls=NO_WALLS if text is None else walls_of(name, [text]),
    )
