from __future__ import annotations

import hashlib
import io
import zipfile

import pytest

from hazbot_gym.utils.checksum import BLANK, MARK, is_whole, seal


def test_a_checksum_is_the_sha256_with_zeros_in_its_place() -> None:
    data = f"a {BLANK} b".encode()
    assert seal(data) == f"a {MARK}{hashlib.sha256(data).hexdigest()} b".encode()


def test_any_other_byte_and_any_cut_shows() -> None:
    whole = seal(f"head {BLANK} tail".encode())
    assert is_whole(whole)
    changed = (
        whole[:i] + bytes([byte ^ bit]) + whole[i + 1 :]
        for i, byte in enumerate(whole)
        for bit in (1, 0x20, 0x80)
    )
    assert not any(map(is_whole, changed))
    assert not any(is_whole(whole[:length]) for length in range(len(whole)))
    assert not is_whole(whole + b" ")


@pytest.mark.parametrize("data", ["", MARK, BLANK + BLANK, BLANK + MARK, BLANK[:-1]])
def test_data_without_one_place_for_it_is_not_sealed(data: str) -> None:
    with pytest.raises(ValueError, match="exactly once"):
        seal(data.encode())
    assert not is_whole(data.encode())


def test_an_archive_carries_it_as_its_comment() -> None:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        archive.writestr("weights", b"\0" * 8)
        archive.comment = BLANK.encode()
    data = seal(content.getvalue())
    assert is_whole(data)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.read("weights") == b"\0" * 8
