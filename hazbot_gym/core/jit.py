"""How the mathematics is compiled, in one place.

Three kinds of functions are used throughout the library:

- ``scalar``: a pure formula on numbers. Plain Python when called from Python, inlined machine code
  when called from a kernel; the same source can be compiled for a GPU.
- ``routine``: the same for a larger piece, which stays a call.
- ``kernel``: a compiled loop over arrays, called from Python and cached on disk; ``lean_kernel``
  where it allocates nothing.

numba looks only at the kernel's own file to decide whether a cached binary is still valid, although
the binary contains code of every formula that the kernel calls. Kernels are therefore stamped with
the contents of every file that their own imports (``sources``).
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.extending import register_jitable

from hazbot_gym.core import notice, sources

PACKAGE = Path(__file__).parent.parent
Function = TypeVar("Function", bound=Callable[..., Any])

# Robots, or people, that are computed side by side. Vector instructions take 4 or 8 of them; loops
# of 8 are unrolled before the compiler looks for vectors, loops of 16 are not.
LANES = 16

# Formulas are called by kernels alone, never through Python's or C's calling convention.
_INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

notice.install()


def scalar(function: Function) -> Function:
    """Mark a formula that kernels may call; from Python it stays a plain Python function.

    It is inlined wherever it is used. The compiler makes vector instructions of a loop only if
    nothing in it is called; and a call that hands over worlds or parameters, which are hundreds of
    words, costs more than most formulas.
    """
    compiled: Function = register_jitable(forceinline=True, **_INNER)(function)
    return compiled


def routine(function: Function) -> Function:
    """Mark a larger piece like ``scalar``, but leave it a call: it is compiled once for all."""
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

    Every view of an array counts one up and down, atomically. Where views are many that costs as
    much as the formulas, and makes threads wait for each other. Such a kernel allocates nothing.
    Formulas are compiled once for all lean kernels, and once more for the others.
    """
    return _compile(function, is_counting=False)


def _compile(function: Function, *, is_counting: bool) -> Function:
    options: dict[str, Any] = {
        "nogil": True,
        "error_model": "numpy",
        "_nrt": is_counting,
        "no_cfunc_wrapper": True,
    }
    compiled: Any = numba.njit(cache=True, **options)(function)
    # Private attributes of numba, held by tests/core/test_jit.py: numba has no public way to say
    # that a cached binary depends on other files besides its own.
    cache = compiled._cache._cache_file
    source = Path(compiled.py_func.__code__.co_filename)
    stamp = sources.digest(PACKAGE, source) if source.is_relative_to(PACKAGE) else ""
    cache._source_stamp = (cache._source_stamp, stamp)
    cache._load_index = functools.partial(_load_index, cache._load_index)
    return cast(Function, compiled)


def _load_index(load: Callable[[], dict[Any, Any]]) -> dict[Any, Any]:
    """Load what is cached; nothing, if another version left it whose classes are not there now.

    numba looks at the stamp only after it has unpickled the types of the arguments.
    """
    try:
        return load()
    except (ImportError, AttributeError):
        return {}
