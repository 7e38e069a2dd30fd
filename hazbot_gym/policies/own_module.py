"""User policies by ``module:attribute``, from installed packages or the working folder.

The working folder is last on the search path, and only during import and construction. So its files
cannot shadow modules of the library or of other packages, and a user policy must import its helpers
before its first ``predict``.
"""

from __future__ import annotations

import ast
import importlib
import importlib.util
import operator
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

from hazbot_gym.errors import InvalidInput


def is_reference(spec: str) -> bool:
    """Return True for text of the form ``module:attribute``, both possibly dotted."""
    module, colon, attribute = spec.partition(":")
    names = (*module.split("."), *attribute.split("."))
    return bool(colon) and all(name.isidentifier() for name in names)


def load(spec: str) -> object:
    """Return the object ``module:attribute``. This executes the module.

    Raises:
        InvalidInput: There is no such module or attribute, the module fails, or its name is that of
            an installed one; one line.
    """
    module_name, _, attribute = spec.partition(":")
    _refuse_two_of_one_name(spec, module_name.partition(".")[0])
    with working_folder():
        module = called(f"importing {module_name!r}", lambda: _import(spec, module_name))
        _refuse_hidden_helpers(spec, module_name.partition(".")[0])
    try:
        return operator.attrgetter(attribute)(module)
    except AttributeError:
        raise InvalidInput(
            f"policy: module {module_name!r} has no attribute {attribute!r}"
        ) from None


def called(what: str, code: Callable[[], object]) -> Any:
    """Call user code and return its result.

    Raises:
        InvalidInput: It fails; one line with the error, file and line number.
    """
    try:
        return code()
    except InvalidInput:
        raise
    except (Exception, SystemExit) as error:
        said = " ".join(f"{type(error).__name__}: {error}".split()).removesuffix(":")
        raise InvalidInput(f"policy: {what} failed: {said} ({_place_of(error)})") from error


def _import(spec: str, name: str) -> object:
    importlib.invalidate_caches()  # the file may be newer than the import cache
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise  # the module exists, but one of its own imports is missing
        raise InvalidInput(f"policy: there is no module {name!r} for {spec!r}") from None


@contextmanager
def working_folder() -> Iterator[None]:
    """Context manager that appends the working folder to the search path."""
    here = str(Path.cwd())
    if here in sys.path or "" in sys.path:
        yield
        return
    sys.path.append(here)
    try:
        yield
    finally:
        sys.path.remove(here)


def _refuse_two_of_one_name(spec: str, name: str) -> None:
    """Reject a module of the working folder with the name of an installed one."""
    local = [path for path in (Path(f"{name}.py"), Path(name)) if path.exists()]
    if not local:
        return
    try:
        found = importlib.util.find_spec(name)
    except ValueError:  # created by a program, without a file
        return
    if found is not None and not _is_local(found, name):
        raise InvalidInput(
            f"policy: {spec!r} names the installed module {name!r} ({found.origin}), not "
            f"{str(local[0])!r} of the working folder; give that another name"
        )


def _refuse_hidden_helpers(spec: str, name: str) -> None:
    """Reject a module of the working folder whose helpers are shadowed by installed modules."""
    waiting, seen = [name], {__name__.partition(".")[0]}
    while waiting:
        top = waiting.pop()
        seen.add(top)
        parts = [module for each, module in sys.modules.items() if f"{each}.".startswith(f"{top}.")]
        for imported in {each for part in parts for each in _imported_by(part)} - seen:
            about = getattr(sys.modules.get(imported), "__spec__", None)
            local = [path for path in _files_of(imported) if path.is_file()]
            if not local or about is None:
                continue
            if not _is_local(about, imported):
                raise InvalidInput(
                    f"policy: {spec!r} imports the installed module {imported!r} ({about.origin}), "
                    f"not {str(local[0])!r} of the working folder; give that another name"
                )
            waiting.append(imported)


def _files_of(name: str) -> tuple[Path, Path]:
    return Path(f"{name}.py"), Path(name, "__init__.py")


def _imported_by(module: ModuleType) -> Iterator[str]:
    """Yield the top-level names of all imports in a module's source, functions included."""
    file = getattr(module, "__file__", None) or ""
    tree = ast.parse(Path(file).read_bytes()) if file.endswith(".py") else ast.Module([], [])
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (each.name.partition(".")[0] for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.partition(".")[0]


def _is_local(found: ModuleSpec, name: str) -> bool:
    here = Path.cwd()
    files = {here / f"{name}.py", here / name / "__init__.py", here / name}
    places = [found.origin, *(found.submodule_search_locations or ())]
    return any(here / place in files for place in places if place is not None)


def _place_of(error: BaseException) -> str:
    """Return the line of the failure in user code, if known."""
    if isinstance(error, SyntaxError):
        return f"line {error.lineno} of {error.filename}"
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename != __file__ and not frame.filename.startswith("<frozen")
    ]
    here = str(Path.cwd())
    frames = [frame for frame in frames if frame.filename.startswith(here)] or frames
    return f"line {frames[-1].lineno} of {frames[-1].filename}" if frames else "in no file"
