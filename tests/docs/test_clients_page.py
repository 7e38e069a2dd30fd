"""The page on other libraries names the versions that ``make clients`` installs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "tests" / "clients").glob("*.txt"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_versions_are_those_of_the_tests(file: Path) -> None:
    page = (ROOT / "docs" / "clients.md").read_text(encoding="utf-8")
    anchor = file.stem.replace("_", "-")
    (seen,) = re.findall(rf"^\|.*\(#{anchor}\) \| (.*?) \|", page, re.MULTILINE)
    pins = re.findall(r"==(\S+)", file.read_text(encoding="utf-8"))
    assert pins == re.findall(r"\d+(?:\.\d+)+", seen)


def test_there_are_files() -> None:
    assert len(FILES) >= 9
