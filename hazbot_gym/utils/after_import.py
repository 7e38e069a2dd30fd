"""Call a function when another module is imported, without importing it."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType


class _AfterImport(MetaPathFinder):
    """Finder that lets the other finders find one module, and calls a function behind it."""

    def __init__(self, name: str, call: Callable[[], None]) -> None:
        self.name, self.call = name, call

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != self.name:
            return None
        sys.meta_path.remove(self)
        try:
            spec = importlib.util.find_spec(fullname)
        finally:
            if fullname not in sys.modules:
                sys.meta_path.insert(0, self)  # until an import succeeds
        if spec is not None and spec.loader is not None:
            self._extend(spec.loader)
        return spec

    def _extend(self, loader: object) -> None:
        execute = loader.exec_module  # type: ignore[attr-defined]  # every loader has it

        def execute_and_call(module: ModuleType) -> None:
            execute(module)
            if self in sys.meta_path:
                sys.meta_path.remove(self)
            self.call()

        loader.exec_module = execute_and_call  # type: ignore[attr-defined]


def after_import(name: str, call: Callable[[], None]) -> None:
    """Call a function now if a top-level module is imported, else when it will be."""
    if sys.modules.get(name) is not None:
        call()
    else:
        sys.meta_path.insert(0, _AfterImport(name, call))
