"""YAML reader of this package: the core schema of YAML 1.2 only.

PyYAML parses; this module resolves scalars. PyYAML's own schema is YAML 1.1, where ``yes`` is a
boolean, ``190:20:30:15`` a number, ``2020-13-45`` an error of the calendar, ``1e-3`` a string, and
the first of two equal keys is dropped.

Source: YAML 1.2.2 (2021), section 10.3, https://yaml.org/spec/1.2.2/#103-core-schema. Left out are
merge keys, tags of other schemas, and keys that are not strings; added are digits in groups of
three, ``3_000_000``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml

from hazbot_gym.errors import InvalidInput

MAX_BYTES = 2**20  # of a file; the largest place of this package has 2 kB
MAX_DEPTH = 50  # of lists and mappings in each other
MAX_VALUES = 1_000_000  # that aliases may unfold to

_TAG = "tag:yaml.org,2002:"
_MAPPING, _SEQUENCE, _STRING = _TAG + "map", _TAG + "seq", _TAG + "str"


def _integer(text: str) -> int:
    base = {"0o": 8, "0x": 16}.get(text[:2], 10)
    return int(text, base)


def _number(text: str) -> float:
    value = float(re.sub(r"\.(?=inf|nan)", "", text.lower()))
    if math.isinf(value) and "inf" not in text.lower():
        raise ValueError("beyond the largest number")
    return value


# Pattern and reader of each tag; the first match resolves a plain scalar.
_SCALARS: dict[str, tuple[re.Pattern[str], Callable[[str], object]]] = {
    _TAG + "null": (re.compile(r"(null|Null|NULL|~|)\Z"), lambda _: None),
    _TAG + "bool": (re.compile(r"(true|True|TRUE|false|False|FALSE)\Z"), lambda s: s[0] in "tT"),
    _TAG + "int": (
        re.compile(r"([-+]?([0-9]+|[0-9]{1,3}(_[0-9]{3})+)|0o[0-7]+|0x[0-9a-fA-F]+)\Z"),
        _integer,
    ),
    _TAG + "float": (
        re.compile(
            r"([-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"
            r"|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))\Z"
        ),
        _number,
    ),
    _STRING: (re.compile(r"[^\ud800-\udfff]*\Z"), str),  # \ud800 is half a character
}


class _Fault(Exception):
    """The text is not usable; the line is counted from 0."""

    def __init__(self, line: int, problem: str) -> None:
        super().__init__(problem)
        self.line, self.problem = line, problem


class _Loader(yaml.BaseLoader):
    """The parser, with plain scalars of the core schema, and a bound on the depth."""

    depth = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.depth > MAX_DEPTH:
            raise _Fault(self.line, f"nested deeper than {MAX_DEPTH}")
        self.depth += 1
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node


for _tag, (_pattern, _) in _SCALARS.items():
    _Loader.add_implicit_resolver(_tag, _pattern, None)


def parse_yaml(text: str, where: str) -> object:
    """Return the value of a YAML text; ``where`` names it in complaints.

    An empty text is None. The value is made of dicts with string keys, lists, str, int, float, bool
    and None.

    Raises:
        InvalidInput: The text is not YAML, or uses more than the core schema; one line.
    """
    try:
        node = _composed(text)
        return None if node is None else _Values().of(node)
    except _Fault as error:
        raise InvalidInput(f"{where}, line {error.line + 1}: {error.problem}") from error


def read_yaml(path: Path, what: str = "config") -> dict[str, object]:
    """Return the mapping in a YAML file; ``what`` names it in complaints.

    An empty file is an empty mapping.

    Raises:
        InvalidInput: The file cannot be read or does not hold a mapping.
    """
    return parse_mapping(read_text(path, what), f"{what}: {path}")


def parse_mapping(text: str, where: str) -> dict[str, object]:
    """Return the mapping in a YAML text; ``where`` names it in complaints.

    Raises:
        InvalidInput: The text is not YAML, or holds no mapping.
    """
    content = parse_yaml(text, where)
    if not isinstance(content, dict | None):
        kind = type(content).__name__
        raise InvalidInput(f"{where} holds {kind}, a mapping is needed")
    return content or {}


def read_text(path: Path, what: str) -> str:
    """Return the text of a YAML file; ``what`` names it in complaints.

    Raises:
        InvalidInput: The file cannot be read, is too large, or is not UTF-8.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InvalidInput(f"{what}: cannot read {path} ({error.strerror})") from error
    if len(data) > MAX_BYTES:
        raise InvalidInput(f"{what}: {path} is larger than {MAX_BYTES >> 20} MiB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InvalidInput(f"{what}: {path}, line {line}: is not YAML (no UTF-8)") from error


def _composed(text: str) -> yaml.Node | None:
    """Return the syntax tree of a text, None of an empty one."""
    loader = None
    try:
        loader = _Loader(text)
        return loader.get_single_node()
    except yaml.reader.ReaderError as error:
        problem = f"the character {chr(error.character)!r} is not allowed"
        raise _Fault(text.count("\n", 0, error.position), problem) from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise _Fault(mark.line if mark else 0, f"is not YAML ({error.problem})") from error
    except (ValueError, OverflowError) as error:  # such as "\U00110000", which PyYAML gives to chr
        raise _Fault(loader.line if loader else 0, "is not YAML (impossible number)") from error


class _Values:
    """The values of a tree's nodes, counted, as aliases can unfold a short text to gigabytes."""

    def __init__(self) -> None:
        self._count = 0

    def of(self, node: yaml.Node, depth: int = 0) -> object:
        self._count += 1
        if self._count > MAX_VALUES or depth > MAX_DEPTH:
            raise _Fault(node.start_mark.line, "aliases unfold to too much")
        if isinstance(node, yaml.MappingNode) and node.tag == _MAPPING:
            return self._mapping(node, depth)
        if isinstance(node, yaml.SequenceNode) and node.tag == _SEQUENCE:
            return [self.of(each, depth + 1) for each in node.value]
        return _scalar(node)

    def _mapping(self, node: yaml.MappingNode, depth: int) -> dict[str, object]:
        mapping: dict[str, object] = {}
        lines: dict[str, int] = {}
        for key_node, value_node in node.value:
            line = key_node.start_mark.line
            if not isinstance(key_node, yaml.ScalarNode) or key_node.tag != _STRING:
                given = getattr(key_node, "value", "") if key_node.tag in _SCALARS else "collection"
                raise _Fault(line, f"key {given!s:.40}: allowed are strings, quoted if need be")
            key = _scalar(key_node)
            if key in mapping:
                raise _Fault(line, f"key {key!r} is given twice, first in line {lines[key] + 1}")
            mapping[key], lines[key] = self.of(value_node, depth + 1), line
        return mapping


def _scalar(node: yaml.Node) -> Any:
    line = node.start_mark.line
    if not isinstance(node, yaml.ScalarNode) or node.tag not in _SCALARS:
        raise _Fault(line, f"tag {node.tag.replace(_TAG, '!!')!r} is not allowed")
    pattern, read = _SCALARS[node.tag]
    given = f"{node.value[:40]!r}"
    if not pattern.match(node.value):
        raise _Fault(line, f"{given} is not a value of {node.tag.replace(_TAG, '!!')}")
    try:
        return read(node.value)
    except ValueError as error:  # too many digits, too large an exponent
        raise _Fault(line, f"{given} is too large a number") from error
