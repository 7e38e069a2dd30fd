"""JIT compilation of kernels with numba, and its cache.

Three kinds of functions are used throughout the library:

- ``scalar``: a pure formula on numbers. Plain Python when called from Python, inlined machine code
  when called from a kernel; the same source can be compiled for a GPU.
- ``routine``: a larger formula that is not inlined.
- ``kernel``: a compiled loop over arrays, called from Python and cached on disk; ``lean_kernel``
  where it allocates nothing.

numba checks only the kernel's own file to validate a cached binary, although the binary contains
code of every called formula. Kernels are therefore stamped with the contents of all files in their
import closure (``sources``).

Binaries are cached in numba's locations: ``NUMBA_CACHE_DIR``, beside the package, or the user's
cache. If none is writable, a private temporary folder is used, or no cache. With
``NUMBA_DISABLE_JIT=1``, or where numba is not installed, everything is plain Python, with equal
numbers up to rounding.
"""

from __future__ import annotations

import functools
import logging
import multiprocessing
import os
import pickle
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from hazbot_gym.core import compile_message, sources

try:
    import numba
    from numba.extending import register_jitable
except ImportError:  # on a robot (``runtime``) it need not be installed
    numba = None  # type: ignore[assignment]

PACKAGE = Path(__file__).parent.parent
Function = TypeVar("Function", bound=Callable[..., Any])

# Robots or people per vectorized loop. Vector instructions process 4 or 8 of them; loops of 8 are
# unrolled before vectorization, loops of 16 are not.
LANES = 16

# Formulas are called by kernels only, never through Python's or C's calling convention.
_INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

_settings: Any = getattr(numba, "config", None)

if numba is not None:
    compile_message.install()


def scalar(function: Function) -> Function:
    """Mark a formula that kernels may call; from Python it stays a plain Python function.

    It is always inlined: loops with calls are not vectorized, and a call with worlds or parameters,
    hundreds of words, costs more than most formulas.
    """
    if numba is None:
        return function
    compiled: Function = register_jitable(forceinline=True, **_INNER)(function)
    return compiled


def routine(function: Function) -> Function:
    """Mark a larger piece like ``scalar``, but do not inline it: it is compiled once."""
    if numba is None:
        return function
    compiled: Function = register_jitable(**_INNER)(function)
    return compiled


def kernel(function: Function) -> Function:
    """Compile an array function on first use and keep the binary on disk.

    Division follows IEEE 754 (no exception on a zero divisor); nothing is reordered (no fast-math),
    so that results do not depend on the processor's vector width.
    """
    return _compile(function, is_counting=True)


def lean_kernel(function: Function) -> Function:
    """Compile like ``kernel``, without counting references to arrays.

    Reference counts of array views are atomic; many views cost as much as the formulas and make
    threads contend. Such a kernel must not allocate. Formulas are compiled once for all lean
    kernels, and once more for the others.
    """
    return _compile(function, is_counting=False)


def is_plain() -> bool:
    """Return True if kernels are plain Python."""
    return numba is None or bool(_settings.DISABLE_JIT)


def _compile(function: Function, *, is_counting: bool) -> Function:
    options: dict[str, object] = {
        "nogil": True,
        "error_model": "numpy",
        "_nrt": is_counting,
        "no_cfunc_wrapper": True,
    }
    if is_plain():
        return cast(Function, functools.partial(_run_plain, function))
    compiled: Any = _with_cache(function, options)
    # Private attributes of numba, held by tests/core/test_jit.py: numba has no public way to say
    # that a cached binary depends on other files besides its own.
    cache = getattr(compiled._cache, "_cache_file", None)
    if cache is not None:
        source = Path(compiled.py_func.__code__.co_filename)
        stamp = sources.digest(PACKAGE, source) if source.is_relative_to(PACKAGE) else ""
        cache._source_stamp = (cache._source_stamp, stamp)
        cache._load_index = functools.partial(_load_index, cache._load_index)
        cache._load_data = functools.partial(_load_data, cache._load_data)
        compiled._cache.save_overload = functools.partial(_save, compiled._cache.save_overload)
    return cast(Function, compiled)


def _run_plain(function: Callable[..., object], *arguments: object) -> object:
    """Call a kernel as plain Python: records have attributes, and numbers behave as compiled."""
    with np.errstate(all="ignore"):
        return function(*(_with_attributes(each) for each in arguments))


def _with_attributes(argument: object) -> Any:
    """Convert arrays of records, also in tuples, to arrays with attribute access."""
    if isinstance(argument, np.ndarray) and argument.dtype.names:
        return argument.view(np.recarray)
    if isinstance(argument, tuple):
        parts = [_with_attributes(each) for each in argument]
        return type(argument)(*parts) if hasattr(argument, "_fields") else tuple(parts)
    return argument


def _with_cache(function: Any, options: dict[str, Any]) -> Any:
    """Return a compiled function with a cache, if possible."""
    for folder in (lambda: _settings.CACHE_DIR, _private_folder):
        try:
            with _caching_in(folder()):
                return numba.njit(cache=True, **options)(function)
        except RuntimeError as error:
            if "no locator available" not in str(error):
                raise
    return numba.njit(**options)(function)


@contextmanager
def _caching_in(folder: str) -> Iterator[None]:
    before = _settings.CACHE_DIR
    _settings.CACHE_DIR = folder
    try:
        yield
    finally:
        _settings.CACHE_DIR = before


@functools.cache
def _private_folder() -> str:
    """Return a cache folder writable by this user only, or "" with a single warning.

    Cached files are unpickled on loading, so that no other user may write them.
    """
    name = PACKAGE.name
    message = f"{name}: no folder to keep compiled code in can be written, so each run compiles"
    folder = ""
    try:
        path = Path(tempfile.gettempdir(), f"{name}-{os.getuid()}")
        path.mkdir(mode=0o700, exist_ok=True)
        found = path.lstat()
        is_mine = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
        if is_mine and not found.st_mode & 0o077:
            folder = str(path)
            message = f"{name}: compiled code is kept in {folder}, no better place can be written"
    except OSError:
        pass
    if multiprocessing.parent_process() is None:  # not repeated by workers
        logging.getLogger(name).warning(f"{message}; NUMBA_CACHE_DIR names another")
    return folder


# Exceptions of unpickling a damaged file, or one of another version with missing classes: numba
# checks the stamp only after unpickling the types of the arguments.
_UNUSABLE = (
    AttributeError, EOFError, ImportError, IndexError, KeyError, MemoryError, OSError, TypeError,
    ValueError, pickle.UnpicklingError,
)  # fmt: skip


def _load_index(load: Callable[[], dict[object, object]]) -> dict[object, object]:
    """Return the cache index, empty if unreadable."""
    try:
        return load()
    except _UNUSABLE:
        return {}


def _load_data(load: Callable[[str], object], name: str) -> object:
    """Return a binary, or None to recompile if the file is missing."""
    try:
        return load(name)
    except _UNUSABLE as error:
        raise FileNotFoundError(name) from error


def _save(save: Callable[[object, object], None], signature: object, binary: object) -> None:
    """Save a binary; a full disk is ignored."""
    try:
        save(signature, binary)
    except OSError:
        return
