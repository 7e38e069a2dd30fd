"""Share of ``Any`` in the package; aliases of it, such as ``JsonObject``, are not counted."""

import ast
from pathlib import Path

import hazbot_gym

MOST_ANY = 4.0  # per thousand lines


def test_any_stays_rare() -> None:
    files = [path.read_text() for path in Path(hazbot_gym.__file__).parent.rglob("*.py")]
    nodes = [node for text in files for node in ast.walk(ast.parse(text))]
    found = sum(isinstance(node, ast.Name) and node.id == "Any" for node in nodes)
    assert found < MOST_ANY * sum(len(text.splitlines()) for text in files) / 1000
