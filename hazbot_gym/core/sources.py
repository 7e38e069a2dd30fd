"""Import closure of a module: all source files of its compiled code.

numba inlines formulas of other files into a kernel, so a cached binary is valid as long as none of
these files has changed. Hashes use contents, not times: a fresh checkout of the same code compiles
nothing.
"""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterator
from pathlib import Path


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
    names = _imported_names(ast.parse(source.read_bytes()))
    paths = (root.parent.joinpath(*name.split(".")) for name in names)
    candidates = (
        file for path in paths for file in (path.with_suffix(".py"), path / "__init__.py")
    )
    return {file for file in candidates if file.is_relative_to(root) and file.is_file()}


def _imported_names(tree: ast.Module) -> Iterator[str]:
    """Yield the dotted names of a file's imports; of ``from a import b`` both a and a.b."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
