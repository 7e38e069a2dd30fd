from __future__ import annotations

import ast
from pathlib import Path

import pytest

import hazbot_gym
from hazbot_gym.core import sources

FILES = {
    "__init__": "",
    "kernel": "from toy.formula import wave\nimport math",
    "formula": "from toy import constants",
    "constants": "import toy.deep.pi",
    "deep/__init__": "",
    "deep/pi": "PI = 3",
    "other": "from toy import formula",
}


def package(tmp_path: Path, **edited: str) -> Path:
    (tmp_path / "toy" / "deep").mkdir(parents=True)
    for name, text in (FILES | edited).items():
        (tmp_path / "toy" / f"{name}.py").write_text(text)
    return tmp_path / "toy"


def test_closure_holds_what_is_imported_at_any_depth_and_nothing_else(tmp_path: Path) -> None:
    root = package(tmp_path)

    found = sources.closure(root, root / "kernel.py")

    assert {path.relative_to(root).as_posix() for path in found} == {
        "__init__.py",
        "kernel.py",
        "formula.py",
        "constants.py",
        "deep/pi.py",
    }


@pytest.mark.parametrize(("edited", "is_other"), [("deep/pi", True), ("other", False)])
def test_digest_changes_with_the_contents_of_what_is_imported(
    tmp_path: Path, edited: str, is_other: bool
) -> None:
    before, after = package(tmp_path / "a"), package(tmp_path / "b", **{edited: "PI = 4"})

    digests = {sources.digest(root, root / "kernel.py") for root in (before, after)}

    assert len(digests) == (2 if is_other else 1)


def test_no_import_of_the_package_is_overlooked() -> None:
    for path in Path(hazbot_gym.__file__).parent.rglob("*.py"):
        source = path.read_bytes()
        parsed = {name for node in ast.walk(ast.parse(source)) for name in sources._names(node)}
        assert parsed <= set(sources._imported_names(source)), path


@pytest.mark.parametrize(
    "statement",
    [
        "import toy.deep.pi, math",
        "import math; import toy.deep.pi",
        "from toy.deep import (\n    pi,  # (a comment)\n    tau,\n)",
        "def f():\n    from toy.deep import pi as ratio",
    ],
)
def test_imports_are_found_in_any_form(statement: str) -> None:
    prose = b'"""Formulas\nfrom nowhere import\nimport (all of it\nfrom a book\n"""\n'
    assert "toy.deep.pi" in set(sources._imported_names(prose + statement.encode()))
