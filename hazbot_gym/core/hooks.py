"""Hooks: scalar functions of users that kernels call by their address.

A hook is plain Python. It is compiled by itself when an environment is made that uses it, and a
kernel calls it through a pointer, so that no kernel is compiled again, and all share one cached
binary. Where kernels are plain Python (``core/jit.py``), the hook is, too.
"""

from __future__ import annotations

import dis
import inspect
import re
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

from hazbot_gym.core import jit
from hazbot_gym.errors import InvalidInput

try:
    import numba
    from llvmlite import ir
    from numba.core import cgutils
    from numba.extending import intrinsic, overload
except ImportError:
    numba = cgutils = None  # type: ignore[assignment]

Untyped = Any  # what comes from numba and llvmlite, which have no types

__all__ = ["NO_HOOK", "Untyped", "address_of", "call", "carray", "check_hook"]

carray: Untyped = getattr(numba, "carray", None)  # pointer and sizes to an array
types: Untyped = getattr(numba, "types", None)
REAL: Untyped = (types.Integer, types.Float, types.Boolean) if types else ()
unpack: Untyped = getattr(cgutils, "unpack_tuple", None)

NO_HOOK = 0  # address of none
SUSPENDED = inspect.CO_GENERATOR | inspect.CO_COROUTINE | inspect.CO_ASYNC_GENERATOR
_PLAIN: list[Callable[..., None]] = [lambda *_: None]  # hooks by address, where nothing is compiled
_COMPILED: dict[Callable[..., object], Untyped] = {}  # they must outlive their addresses


def call(address: int, *arguments: object) -> None:
    """Call a hook: from a kernel, compiled code at an address."""
    _PLAIN[int(address)](*arguments)


if numba is not None:

    @overload(call)
    def _call_compiled(address: Untyped, *arguments: Untyped) -> Untyped:
        def jump(address: Untyped, *arguments: Untyped) -> Untyped:
            return _jump(address, *arguments)

        return jump

    @intrinsic
    def _jump(typing_context: Untyped, address: Untyped, *arguments: Untyped) -> Untyped:
        """Call the C function at an address: records as pointers, arrays as pointer and sizes."""

        def generate(
            context: Untyped, builder: Untyped, signature: Untyped, values: Untyped
        ) -> Untyped:
            passed: list[Untyped] = []
            given = unpack(builder, values[1])
            for kind, value in zip(signature.args[1], given, strict=True):
                if isinstance(kind, types.Array):
                    array = context.make_array(kind)(context, builder, value)
                    passed.append(builder.bitcast(array.data, cgutils.voidptr_t))
                    passed.extend(unpack(builder, array.shape))
                elif isinstance(kind, types.Record):
                    passed.append(builder.bitcast(value, cgutils.voidptr_t))
                else:
                    passed.append(value)
            c_function = ir.FunctionType(ir.VoidType(), [each.type for each in passed])
            builder.call(builder.inttoptr(values[0], c_function.as_pointer()), passed)
            return context.get_dummy_value()

        return types.void(address, types.StarArgTuple(arguments)), generate


def address_of(
    what: str,
    function: Callable[..., object],
    *,
    examples: tuple[object, ...],
    results: int,
    passed: tuple[object, ...],
    adapted: Callable[[Callable[..., Untyped]], tuple[Callable[..., None], Callable[..., None]]],
) -> int:
    """Return the address at which kernels call a user's function.

    Args:
        what: Name of the hook for messages, such as "reward term 'near_walls'".
        function: The function.
        examples: Examples of its arguments, for their types.
        results: Number of numbers that it returns.
        passed: Examples of the arguments of ``call``.
        adapted: Returns two functions that call it and store its results: one with the arguments
            of ``call``, and one with pointers and sizes, which ``carray`` converts.

    Raises:
        InvalidInput: It cannot be compiled; one line says why.
    """
    if jit.is_plain():
        _PLAIN.append(adapted(function)[0])
        return len(_PLAIN) - 1
    if function not in _COMPILED:
        inner = _compiled(what, function, examples, results)
        entry = adapted(inner)[1]
        entry.__module__ = function.__module__  # no kernel of this package (compile_message)
        _COMPILED[function] = numba.cfunc(_signature(passed), error_model="numpy")(entry)
    return int(_COMPILED[function].address)


def _compiled(
    what: str, function: Callable[..., object], examples: tuple[object, ...], results: int
) -> Untyped:
    """Return a compiled function, after a check of what it returns."""
    compiled = numba.njit(error_model="numpy", nogil=True, boundscheck=True)(function)
    try:
        compiled.compile(tuple(map(numba.typeof, examples)))
    except Exception as error:  # besides numba's own: KeyError of a field, AttributeError of numpy
        reason, place = _reason(error), _place_of(function, error)
        raise InvalidInput(f"{what}: cannot be compiled, {reason} ({place})") from error
    returned = compiled.nopython_signatures[0].return_type
    parts = tuple(returned) if isinstance(returned, types.BaseTuple) else (returned,)
    are_numbers = all(isinstance(part, REAL) for part in parts)
    if not are_numbers or len(parts) != results:
        allowed = "a number" if results == 1 else f"{results} numbers"
        raise InvalidInput(f"{what}: returns {_brief(str(returned))}, allowed is {allowed}")
    return compiled


def _signature(passed: tuple[object, ...]) -> Untyped:
    """Return the C signature: pointers for records and arrays, and sizes behind those of arrays."""
    pieces: list[Untyped] = []
    for kind in map(numba.typeof, passed):
        if isinstance(kind, types.Array):
            pieces.extend([types.CPointer(kind.dtype), *[types.intp] * kind.ndim])
        else:
            pieces.append(types.CPointer(kind) if isinstance(kind, types.Record) else kind)
    return types.void(*pieces)


def _reason(error: Exception) -> str:
    """Return the reason of a compiler error as one line."""
    if isinstance(error, KeyError):
        return f"no field {error}"
    lines = [line.strip() for line in str(error).splitlines()]
    said = [line for line in lines if line and not line.startswith("Failed in nopython mode")]
    if not said:
        return type(error).__name__
    return _brief(said[0].removesuffix(" Raised from None").rstrip(".:"))


def _brief(said: str) -> str:
    """Return a compiler's message without the fields of records, which are thousands of letters."""
    return re.sub(r"(Record|Situation)\(.*\)", r"\1", said)


def _place_of(function: Callable[..., object], error: Exception | None = None) -> str:
    """Return the line of an error in a function, or of the function."""
    location, code = getattr(error, "loc", None), _code_of(function)
    line = getattr(location, "line", None) or code.co_firstlineno
    return f"line {line} of {getattr(location, 'filename', None) or code.co_filename}"


def _code_of(function: Untyped) -> Untyped:
    return function.__code__


def check_hook(what: str, function: object, parameters: Sequence[str], taken: Sequence[str]) -> str:
    """Return the name of a user's function, checked.

    Args:
        what: Kind of the hook for messages.
        function: The function.
        parameters: What it must take, in this order; their names are free.
        taken: Names that the library uses itself.

    Raises:
        InvalidInput: It is no plain function, takes other parameters, has a name that is taken, or
            writes fields of records.
    """
    if not isinstance(function, FunctionType):
        raise InvalidInput(f"{what}: given {function!r}, allowed is a function")
    name, given = function.__name__, inspect.signature(function).parameters.values()
    if not name.isidentifier() or name in taken:
        reason = "is one of the library's" if name in taken else "is not a name"
        raise InvalidInput(f"{what}: given {name!r}, which {reason}")
    if len(given) != len(parameters) or any(p.kind is not p.POSITIONAL_OR_KEYWORD for p in given):
        said, allowed = ", ".join(each.name for each in given), ", ".join(parameters)
        raise InvalidInput(
            f"{what} {name!r}: takes ({said}), allowed is ({allowed}) ({_place_of(function)})"
        )
    _check_code(f"{what} {name!r}", function)
    return name


def _check_code(what: str, function: FunctionType) -> None:
    """Raise if a call would not run to its end, or would write fields of the simulation."""
    if function.__code__.co_flags & SUSPENDED:
        raise InvalidInput(
            f"{what}: waits or yields, allowed is a plain function ({_place_of(function)})"
        )
    for each in dis.get_instructions(function):
        if each.opname in ("STORE_ATTR", "DELETE_ATTR"):
            line = each.positions.lineno if each.positions else None
            raise InvalidInput(
                f"{what}: writes .{each.argval}, allowed is to read "
                f"(line {line} of {function.__code__.co_filename})"
            )
