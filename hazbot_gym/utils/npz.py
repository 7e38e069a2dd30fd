"""Safe reading of untrusted ``.npz`` files: sizes and headers are checked first.

numpy's own reader allocates what a header says, terabytes too, and unpacks what a zip says. Here a
file and its arrays together may take ``MOST_BYTES`` each, and an array is read only if it is a
plain one of allowed numbers, as long as its header says.
"""

from __future__ import annotations

import io
import math
import re
import zipfile
import zlib
from pathlib import Path
from typing import IO

import numpy as np
import numpy.typing as npt

MOST_BYTES = 128 * 2**20
MOST_ARRAYS = 1000
MOST_HEADER = 10_000
_HEADER = re.compile(
    rb"\{'descr': '(?P<type>[<>|=]?[a-zA-Z][0-9]+)', 'fortran_order': (?P<order>True|False), "
    rb"'shape': \((?P<shape>[0-9, ]*)\), \}\s*"
)
_ENTRY = b"PK\x01\x02"  # begins each entry of a zip's table of contents
_ENCRYPTED = 1
# Exceptions of numpy and zipfile for foreign or damaged files.
_DAMAGE = (
    EOFError, OverflowError, RuntimeError, TypeError, ValueError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


class Unreadable(ValueError):
    """A file is no ``.npz`` of plain numbers within the bounds; the message gives the reason."""


def read_arrays(path: Path, kinds: str) -> dict[str, npt.NDArray[np.generic]]:
    """Return the arrays of a file by name, in the machine's byte order and C order.

    Args:
        path: Of the file.
        kinds: Allowed ``dtype.kind``, such as ``fu`` for real and unsigned numbers.

    Raises:
        OSError: The file cannot be read.
        Unreadable: Its content cannot be used.
    """
    with path.open("rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES or data.count(_ENTRY) > MOST_ARRAYS:
        raise Unreadable(f"it has more than {MOST_BYTES >> 20} MiB or {MOST_ARRAYS} arrays")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return _arrays(archive, kinds)
    except Unreadable:
        raise
    except _DAMAGE as error:
        raise Unreadable("its zip cannot be unpacked") from error


def _arrays(archive: zipfile.ZipFile, kinds: str) -> dict[str, npt.NDArray[np.generic]]:
    entries = archive.infolist()
    if sum(entry.file_size for entry in entries) > MOST_BYTES:
        raise Unreadable(f"its arrays take more than {MOST_BYTES >> 20} MiB")
    found: dict[str, npt.NDArray[np.generic]] = {}
    for entry in entries:
        name = entry.filename.removesuffix(".npy")
        is_plain = entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
        if name in found or not is_plain or entry.flag_bits & _ENCRYPTED:
            raise Unreadable(f"its entry {name!r} is there twice, or packed in another way")
        with archive.open(entry) as file:
            found[name] = _array(file, entry.file_size, name, kinds)
    return found


def _array(file: IO[bytes], size: int, name: str, kinds: str) -> npt.NDArray[np.generic]:
    dtype, is_fortran, shape = _header(file, name)
    if dtype.kind not in kinds:
        raise Unreadable(f"its array {name!r} has type {dtype}")
    if math.prod(shape) * dtype.itemsize != size - file.tell():
        raise Unreadable(f"its array {name!r} is not as long as it says")
    values = np.frombuffer(file.read(), dtype).reshape(shape, order="F" if is_fortran else "C")
    return np.array(values, dtype.newbyteorder("="), order="C")


def _header(file: IO[bytes], name: str) -> tuple[np.dtype[np.generic], bool, tuple[int, ...]]:
    """Return type, order and shape of an array; a header of numpy's is matched, not evaluated."""
    digits = {b"\x93NUMPY\x01\x00": 2, b"\x93NUMPY\x02\x00": 4}.get(file.read(8), 0)
    size = int.from_bytes(file.read(digits), "little")
    text = file.read(size) if size <= MOST_HEADER else b""
    found = _HEADER.fullmatch(text)
    if found is None:
        raise Unreadable(f"its array {name!r} is no plain one")
    shape = tuple(int(length) for length in found["shape"].split(b",") if length.strip())
    return np.dtype(found["type"].decode()), found["order"] == b"True", shape
