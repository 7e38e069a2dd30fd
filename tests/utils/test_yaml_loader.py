"""The one YAML loader: values of the core schema, and one line for everything else."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils.yaml_loader import MAX_BYTES, parse_yaml, read_yaml
from tests.refusals import refused


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True),
        ("False", False),
        ("yes", "yes"),
        ("off", "off"),
        ("on", "on"),
        ("~", None),
        ("null", None),
        ("", None),
        ("# nothing here", None),
        ("12", 12),
        ("-3", -3),
        ("010", 10),
        ("0o17", 15),
        ("0x1F", 31),
        ("3_000_000", 3_000_000),
        ("1_0", "1_0"),
        ("0b1", "0b1"),
        ("190:20:30:15", "190:20:30:15"),
        ("1e-3", 0.001),
        ("1E3", 1000.0),
        (".5", 0.5),
        ("5.", 5.0),
        ("-.inf", -math.inf),
        ("2020-01-02", "2020-01-02"),
        ("2020-13-45", "2020-13-45"),
        ("'5'", "5"),
        ("!!str 5", "5"),
        ("!!float 3", 3.0),
        ("=", "="),
        ("[1, {a: b}]", [1, {"a": "b"}]),
        ("a: &x [1]\nb: *x", {"a": [1], "b": [1]}),
        ("<<: 1", {"<<": 1}),
    ],
)
def test_scalars_mean_what_the_core_schema_says(text: str, value: Any) -> None:
    found = parse_yaml(text, "a text")

    assert found == value
    assert type(found) is type(value)


def test_not_a_number_is_read() -> None:
    assert math.isnan(parse_yaml(".nan", "a text"))


LAUGHS = "\n".join(
    ["k0: &k0 [1, 1]", *(f"k{i}: &k{i} [{', '.join([f'*k{i - 1}'] * 9)}]" for i in range(1, 12))]
)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("a: 1\nb: 2\na: 3", "line 3 ... key 'a' ... line 1"),
        ("a: {b: [{c: 1,\n c: 2}]}", "line 2 ... key 'c' ... line 1"),
        ("a: 1\n'a': 2", "line 2 ... key 'a' ... line 1"),
        ("a: 1\n1: 2", "line 2 ... key 1 ... strings"),
        ("true: 2", "line 1 ... key true ... strings"),
        ("{[1]: 2}", "line 1 ... key collection ... strings"),
        ("!!int ''", "line 1 ... '' ... !!int"),
        ("!!bool yes", "line 1 ... 'yes' ... !!bool"),
        ("a: 1\nb: !!python/name:os.system", "line 2 ... '!!python/name:os.system'"),
        ("!mine 3", "line 1 ... '!mine'"),
        ("!!map 3", "line 1 ... '!!map'"),
        ("!!set {a}", "line 1 ... '!!set'"),
        ("9" * 5000, "too large"),
        ("1e999", "'1e999' ... too large"),
        ("[" * 5000, "50"),
        ("{a: " * 5000, "50"),
        ("- " * 5000, "50"),
        ("&a [*a]", "aliases"),
        (LAUGHS, "aliases"),
        ("a: 1\n\tb: 2", "line 2 ... YAML"),
        ("a: 1\nb: \0", "line 2 ... '\\x00'"),
        ('"\\U00110000"', "line 1 ... YAML"),
        ('"\\UFFFFFFFF"', "line 1 ... YAML"),
        ('"\\ud800"', "line 1 ... '\\ud800' ... !!str"),
        ("%YAML 1." + "9" * 5000 + "\n--- 1", "YAML"),
        ("--- 1\n--- 2", "line 2 ... YAML"),
        ("*a", "line 1 ... YAML ... alias 'a'"),
    ],
)
def test_what_is_not_allowed_is_one_line_with_its_line_number(text: str, complaint: str) -> None:
    with refused(f"a text ... line ... {complaint.removeprefix('line ')}"):
        parse_yaml(text, "a text")


@given(st.text(alphabet="ab01.-+e:_ \n\t'\"[]{},&*!|>%#?~<=@`\\xuU\0\ud800\ufeffé", max_size=30))
@example("!!float")
@example("!!null x")
@example("? [a]\n: b")
@example("%TAG ! x\n--- !y 3")
@settings(max_examples=400, deadline=None)
def test_any_text_is_a_value_or_one_line(text: str) -> None:
    message = ""
    try:
        parse_yaml(text, "a text")
    except InvalidInput as error:
        message = str(error)
    assert "\n" not in message


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text("aé 1:#-"),
        lambda each: st.lists(each, max_size=3) | st.dictionaries(st.text("ab1"), each, max_size=3),
        max_leaves=8,
    )
)
@settings(max_examples=200, deadline=None)
def test_dumped_values_come_back(value: Any) -> None:
    assert parse_yaml(yaml.safe_dump(value), "a text") == value


@pytest.mark.parametrize("content", [b"", b"# nothing\n", b"\xef\xbb\xbf", b"{}", b"null"])
def test_empty_file_is_an_empty_mapping(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(content)

    assert read_yaml(path) == {}


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"- 1", "list ... mapping"),
        (b"false", "bool ... mapping"),
        (b"a: 1\nb: \xff", "line 2 ... YAML ... UTF-8"),
        (b"a" * (MAX_BYTES + 1), "1 MiB"),
    ],
)
def test_file_that_is_no_mapping_is_refused_by_its_name(
    tmp_path: Path, content: bytes, complaint: str
) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(content)

    with refused(f"place ... {path} ... {complaint}"):
        read_yaml(path, "place")


def test_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with refused("config ... Is a directory"):
        read_yaml(tmp_path)
