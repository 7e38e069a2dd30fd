"""Compiled kernels as a WebAssembly module, for browsers: the formulas of the library, not a copy.

numba keeps the LLVM code of a compiled kernel, in which everything it calls is inlined. Here
llvmlite emits that code once more, for wasm32. Nothing is reordered or contracted, so that results
have the bits of the machine's own code, except for the functions of ``MATH``, which the browser
computes.

The code was optimized for 64-bit addresses. That is no harm as long as addresses are only
arguments: a kernel that keeps one in memory is refused. An object file is a WebAssembly module but
for the exports, because LLVM fills in addresses and indices as if it was linked alone; so no linker
is needed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numba
import numpy as np
from llvmlite import binding as llvm

from hazbot_gym.core.hooks import Untyped
from hazbot_gym.errors import InvalidInput

OLDEST_LLVM = (20,)  # whose code has opaque pointers
MATH = {"atan2", "cos", "erf", "exp", "log", "pow", "sin"}
RUNTIME = {"__multi3", "__linear_memory", "__stack_pointer", "__indirect_function_table"}
FIRST = 65536  # address of the first array; below are constants, and the stack above them
RETURNED, FAILED = 1024, 1032  # addresses of what a kernel returns, and of its exception: unused
FEATURES = "+simd128,+bulk-memory"
# An address that is read from memory, or a structure there, which might hold one.
_KEEPS_ADDRESS = re.compile(r"= load ptr|store ptr (?!null)|alloca \{")
_IMPORT, _CODE, _EXPORT, _COUNT_OF_DATA, _CUSTOM = 2, 10, 7, 12, 0
_FUNCTION, _TABLE, _MEMORY, _GLOBAL = range(4)  # kinds of imports

Argument = int | float | str  # an address, a float, and a 64-bit integer as digits


class Kernel(NamedTuple):
    """A kernel with its arguments, which select its signature."""

    function: Untyped
    arguments: Sequence[object]


class Image:
    """Memory of a module: arrays one after another.

    Attributes:
        first: Address of the first array.
        end: Address behind the last.
    """

    def __init__(self, shared: Image | None = None) -> None:
        """Make a memory, behind another one whose arrays it also has."""
        self._shared = shared
        self._arrays: dict[int, tuple[int, Untyped]] = {}  # by id; kept, so that ids stay theirs
        self.first: int = shared.end if shared else FIRST
        self.end: int = self.first

    def address(self, array: Untyped) -> int:
        """Return the address of an array, always the same one."""
        if self._shared and id(array) in self._shared._arrays:
            return self._shared.address(array)
        if id(array) not in self._arrays:
            if not array.flags.c_contiguous:
                raise InvalidInput(f"array: given strides {array.strides}, allowed are contiguous")
            self._arrays[id(array)] = self.end, array
            self.end += -(-array.nbytes // 16) * 16
        return self._arrays[id(array)][0]

    def arguments(self, *values: object) -> list[Argument]:
        """Return the arguments of a call as numba passes them, arrays in pieces."""
        return [RETURNED, FAILED, *(piece for value in values for piece in self._pieces(value))]

    def _pieces(self, value: Untyped) -> Iterator[Argument]:
        if isinstance(value, np.ndarray):
            yield from (0, 0, str(value.size), str(value.itemsize), self.address(value))
            yield from map(str, (*value.shape, *value.strides))
        elif isinstance(value, tuple):
            for part in value:
                yield from self._pieces(part)
        elif isinstance(value, bool):
            yield int(value)
        else:
            yield str(int(value)) if isinstance(value, int | np.integer) else float(value)

    def content(self) -> bytes:
        """Return the memory from ``first`` to ``end``, with the present values of the arrays."""
        memory = bytearray(self.end - self.first)
        for address, array in self._arrays.values():
            memory[address - self.first : address - self.first + array.nbytes] = array.tobytes()
        return bytes(memory)


def compiled(kernels: Mapping[str, Kernel]) -> bytes:
    """Return a WebAssembly module that exports some kernels by name.

    It imports ``MATH`` and ``RUNTIME`` of ``env``. A kernel takes the pieces of
    ``Image.arguments``.

    Raises:
        InvalidInput: A kernel cannot be compiled for it, or LLVM is too old; one line says why.
    """
    if llvm.llvm_version_info < OLDEST_LLVM:
        found, least = llvm.llvm_version_info[0], OLDEST_LLVM[0]
        raise InvalidInput(f"llvmlite: given LLVM {found}, allowed is {least} or newer")
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    names = list(kernels)
    module = _module(names[0], kernels[names[0]])
    for name in names[1:]:
        module.link_in(_module(name, kernels[name]))
    target = llvm.Target.from_triple("wasm32-unknown-unknown")
    machine = target.create_target_machine(opt=2, features=FEATURES, reloc="static")
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    _optimize(module, machine)
    if kept := _KEEPS_ADDRESS.search(str(module)):
        raise InvalidInput(f"kernels: one keeps an address in memory ({kept.group()})")
    defined = [each.name for each in module.functions if not each.is_declaration]
    exported = {name: defined.index(name) for name in names}
    return _with_exports(machine.emit_object(module), exported)


def _module(name: str, kernel: Kernel) -> Untyped:
    """Return the LLVM module of a kernel, with nothing but the kernel to be seen from outside."""
    signature = tuple(map(numba.typeof, kernel.arguments))
    overload = kernel.function.overloads.get(signature)
    if overload is None:
        kernel.function.compile(signature)
        overload = kernel.function.overloads[signature]
    # Private methods of numba, held by tests/export/test_wasm.py: a kernel from the cache has no
    # other form of its code.
    code = overload.library._get_module_for_linking().as_bitcode()
    module = llvm.parse_bitcode(code)
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration:
            each.linkage = "internal"
    entry = module.get_function(overload.fndesc.llvm_func_name)
    entry.linkage, entry.name = "external", name
    return module


def _optimize(module: Untyped, machine: Untyped) -> None:
    """Leave out what no kernel uses, such as the wrappers for Python."""
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=1))
    builder.getModulePassManager().run(module, builder)


# --- the binary format ---------------------------------------------------------------------------


def _with_exports(file: bytes, exported: Mapping[str, int]) -> bytes:
    """Return an object file as a module that exports functions, given by name and index."""
    made, imported, is_told = bytearray(file[:8]), 0, False
    for kind, content in _sections(file):
        if kind == _CUSTOM:  # for linkers
            continue
        if kind == _IMPORT:
            imports = list(_imports(content))
            if strange := {name for name, _ in imports} - MATH - RUNTIME:
                raise InvalidInput(f"kernels: need {', '.join(sorted(strange))}")
            imported = sum(of == _FUNCTION for _, of in imports)
        if kind in (_COUNT_OF_DATA, _CODE) and not is_told:
            exports = [
                _text(name) + bytes([_FUNCTION]) + _number(imported + k)
                for name, k in exported.items()
            ]
            made += _section(_EXPORT, _number(len(exports)) + b"".join(exports))
            is_told = True
        made += _section(kind, content)
    return bytes(made)


def _sections(file: bytes) -> Iterator[tuple[int, bytes]]:
    at = 8
    while at < len(file):
        kind, (size, start) = file[at], _read(file, at + 1)
        at = start + size
        yield kind, file[start:at]


def _imports(content: bytes) -> Iterator[tuple[str, int]]:
    """Yield name and kind of each import."""
    count, at = _read(content, 0)
    for _ in range(count):
        for _ in range(2):  # module and name
            size, start = _read(content, at)
            at = start + size
        name, kind = content[start:at].decode(), content[at]
        at += {_FUNCTION: 1, _TABLE: 3, _MEMORY: 2, _GLOBAL: 3}[kind]  # up to the last number,
        if kind != _GLOBAL:
            _, at = _read(content, at)  # which is an index or a size
        yield name, kind


def _section(kind: int, content: bytes) -> bytes:
    return bytes([kind]) + _number(len(content)) + content


def _text(text: str) -> bytes:
    return _number(len(text)) + text.encode()


def _number(value: int) -> bytes:
    """Return a number in LEB128."""
    digits = []
    while value > 127:
        digits.append(value & 127 | 128)
        value >>= 7
    return bytes([*digits, value])


def _read(content: bytes, at: int) -> tuple[int, int]:
    """Return a number in LEB128, and where it ends."""
    value, shift = 0, 0
    while content[at] > 127:
        value |= (content[at] & 127) << shift
        at, shift = at + 1, shift + 7
    return value | content[at] << shift, at + 1
