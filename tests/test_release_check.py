"""The release check knows every extra; the check itself takes minutes and is not run here."""

from __future__ import annotations

import importlib.util
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_each_extra_is_used_in_an_environment_of_its_own() -> None:
    spec = importlib.util.spec_from_file_location("release_check", ROOT / ".ci/release_check.py")
    assert spec is not None
    assert spec.loader is not None
    check = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(check)
    with (ROOT / "pyproject.toml").open("rb") as file:
        declared = tomllib.load(file)["project"]["optional-dependencies"]

    assert set(check.USES) - {""} == set(declared) - {"all", "docs", "dev"}
