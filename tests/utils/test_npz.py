"""Arrays of unknown origin: what is read, what is refused, and how little memory that takes."""

from __future__ import annotations

import io
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.utils.npz import Unreadable, read_arrays
from tests.refusals import refused


@pytest.fixture
def one() -> bytes:
    return npy(np.zeros(3))


def zipped(path: Path, *entries: tuple[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, data in entries:
            archive.writestr(name, data)
    return path


def header(text: str) -> bytes:
    padded = text.ljust(118 - len(text) % 64 + len(text)) + "\n"
    return b"\x93NUMPY\x01\x00" + len(padded).to_bytes(2, "little") + padded.encode()


def npy(array: Any) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


@pytest.mark.parametrize(
    "array",
    [
        np.arange(6.0).reshape(2, 3),
        np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        np.arange(6, dtype=">f4"),
        np.float16([1.5]),
        np.array(3.0),
        np.zeros((0, 4)),
    ],
)
def test_plain_arrays_come_back_in_native_and_c_order(array: Any, tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez_compressed(path, array=array)

    (found,) = read_arrays(path, "f").values()

    assert np.array_equal(found, array)
    assert found.dtype.isnative
    assert found.flags.c_contiguous
    assert found.flags.writeable


PLAIN = "{'descr': '<f4', 'fortran_order': False, 'shape': (3,), }"


@pytest.mark.parametrize(
    "content",
    [
        header(PLAIN.replace("(3,)", "(1000000000000,)")) + bytes(12),  # 3.6 TiB
        header(PLAIN.replace("(3,)", "(-3,)")) + bytes(12),
        header(PLAIN.replace("(3,)", "(-1, 0)")),
        header(PLAIN.replace("(3,)", "(3.0,)")) + bytes(12),
        header(PLAIN) + bytes(11),
        header(PLAIN) + bytes(13),
        header(PLAIN.replace("<f4", "|O")) + bytes(24),
        header(PLAIN.replace("'<f4'", "[('a', '<f4')]")) + bytes(12),
        header(PLAIN.replace("'<f4'", "('<f4', (2,))")) + bytes(24),
        header("(" * 5000),
        header("-" * 9000 + "1"),
        header("[" * 150 + "]" * 150),
        b"\x93NUMPY\x03\x00" + bytes(30),
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff{}",
        b"not an array",
        b"",
        npy(np.zeros(3, np.complex64)),
        npy(np.array(["a"])),
        npy(np.zeros(3, "datetime64[s]")),
        npy(np.zeros(3, np.int64)),
        npy(np.zeros(3, bool)),
    ],
)
def test_what_is_no_plain_array_of_allowed_numbers_is_refused(
    content: bytes, tmp_path: Path
) -> None:
    with refused(error=Unreadable):
        read_arrays(zipped(tmp_path / "a.npz", ("a.npy", content)), "f")


def test_bombs_are_refused_within_a_bound_of_memory(tmp_path: Path) -> None:
    bomb, many, big = (tmp_path / f"{name}.npz" for name in ("bomb", "many", "big"))
    zipped(bomb, ("a.npy", bytes(200 * 2**20)))
    zipped(many, *((f"{i}.npy", b"") for i in range(2000)))
    with big.open("wb") as sparse:
        sparse.truncate(2**33)
    tracemalloc.start()
    for path in (bomb, many, big):
        with refused("more than 128 MiB", error=Unreadable):
            read_arrays(path, "f")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 2.2 * 2**27


def test_a_table_of_contents_that_lies_is_refused(tmp_path: Path) -> None:
    path = zipped(tmp_path / "a.npz", ("a.npy", npy(np.zeros(5000))))
    data = bytearray(path.read_bytes())
    place = data.rindex(b"PK\x01\x02") + 24  # the size, unpacked
    data[place : place + 4] = (1000).to_bytes(4, "little")
    path.write_bytes(data)
    with refused(error=Unreadable):
        read_arrays(path, "f")


def test_other_packings_are_refused(tmp_path: Path, one: bytes) -> None:
    with refused("packed", error=Unreadable):
        read_arrays(zipped(tmp_path / "a.npz", ("a.npy", one), method=zipfile.ZIP_LZMA), "f")


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_names_given_twice_are_refused(tmp_path: Path, one: bytes) -> None:
    with refused("'a'", error=Unreadable):
        read_arrays(zipped(tmp_path / "twice.npz", ("a.npy", one), ("a.npy", one)), "f")


def test_a_path_that_is_no_file_is_the_system_s_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        read_arrays(tmp_path / "nowhere.npz", "f")
    with pytest.raises(IsADirectoryError):
        read_arrays(tmp_path, "f")
