"""Embedded checksums that detect any changed byte and keep the file format valid.

The file's bytes hold ``MARK`` and 64 hexadecimal digits exactly once: in a JSON object as a value,
in a parquet file as metadata, in a zip archive as its comment. The digits are the SHA-256 of all
bytes of the file, with zeros where the digits are.
"""

from __future__ import annotations

import hashlib

MARK = "hazbot-sha256:"
BLANK = MARK + "0" * 64


def seal(data: bytes) -> bytes:
    """Return the bytes of a file with its checksum filled in where ``BLANK`` is.

    Raises:
        ValueError: ``BLANK`` is not in it, or ``MARK`` is in it more than once.
    """
    if data.count(BLANK.encode()) != 1 or data.count(MARK.encode()) != 1:
        raise ValueError(f"{MARK!r} and 64 zeros must be in the data exactly once")
    return data.replace(BLANK.encode(), (MARK + hashlib.sha256(data).hexdigest()).encode())


def is_whole(data: bytes) -> bool:
    """Return True if the bytes of a file match their checksum."""
    before, mark, after = data.partition(MARK.encode())
    if not mark or MARK.encode() in after:
        return False
    blank = before + BLANK.encode() + after[64:]
    return after[:64] == hashlib.sha256(blank).hexdigest().encode()
