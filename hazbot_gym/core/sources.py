"""Import closure of a module: all source files of its compiled code.

numba inlines formulas of other files into a kernel, so a cached binary is valid as long as none of
these files has changed. Hashes use contents, not times: a fresh checkout of the same code compiles
nothing.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import hashlib
import re
from collections.abc import Iterator
from pathlib import Path

# Import statements alone are parsed: whole files would delay every start by a quarter of a second.
# Prose that reads like a statement only adds a file.
_STATEMENT = re.compile(
    rb"^[ \t]*(from[ \t]+\S+[ \t]+import[ \t]*\((?:[\w\s,]|#.*\n)*\)|(?:from|import)[ \t].+)",
    re.MULTILINE,
)


def digest(root: Path, source: Path) -> str:
    """Return a hash of a source file and of every file of its package that it imports.

    Args:
        root: Folder of the package.
        source: A file in it.
    """
    total = hashlib.sha256()
    for path in sorted(closure(root, source)):
        total.update(path.relative_to(root).as_posix().encode())
        total.update(_content(path))
    return total.hexdigest()


def closure(root: Path, source: Path) -> set[Path]:
    """Return a source file and every file of its package that it imports, directly or not."""
    found, waiting = {source}, [source]
    while waiting:
        new = _imports(root, waiting.pop()) - found
        found |= new
        waiting.extend(new)
    return found


@functools.cache
def _content(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()


@functools.cache
def _imports(root: Path, source: Path) -> set[Path]:
    """Return the files of the package that one file imports."""
    names = _imported_names(source.read_bytes())
    paths = (root.parent.joinpath(*name.split(".")) for name in names)
    candidates = (
        file for path in paths for file in (path.with_suffix(".py"), path / "__init__.py")
    )
    return {file for file in candidates if file.is_relative_to(root) and file.is_file()}


def _imported_names(source: bytes) -> Iterator[str]:
    """Yield the dotted names of a file's imports; of ``from a import b`` both a and a.b."""
    for found in _STATEMENT.findall(source):
        with contextlib.suppress(SyntaxError):  # prose
            for node in ast.parse(found).body:
                yield from _names(node)


def _names(node: ast.AST) -> Iterator[str]:
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module:
        yield node.module
        yield from (f"{node.module}.{alias.name}" for alias in node.names)
