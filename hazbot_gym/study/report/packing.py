"""Compression of what the page holds: text as deflated base64, which ``inflate.js`` reads."""

from __future__ import annotations

import base64
import json
import zlib


def packed_text(text: str) -> str:
    """Return a text as base64 of its deflated bytes."""
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode()


def packed_json(content: object) -> str:
    """Return plain values as ``packed_text`` of their JSON."""
    return packed_text(json.dumps(content, separators=(",", ":"), allow_nan=False))
