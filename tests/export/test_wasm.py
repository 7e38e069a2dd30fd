"""Kernels as WebAssembly: what is refused, and in a browser the bits of the machine's own code."""

from __future__ import annotations

import base64
import json
import math
from typing import Any

import numpy as np
import pytest
from llvmlite import binding

from hazbot_gym.core.elementary import decay, sin_cos
from hazbot_gym.core.jit import is_plain, lean_kernel
from hazbot_gym.core.noise import uniform4
from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput
from hazbot_gym.export.wasm import FIRST, OLDEST_LLVM, Image, Kernel, compiled

pytestmark = pytest.mark.skipif(
    is_plain() or binding.llvm_version_info < OLDEST_LLVM,
    reason="needs compiled kernels of LLVM 20",
)

COUNT = 4000
RUN = """
const memory = new WebAssembly.Memory({ initial: 8 });
const { log, cos, sin, exp, pow, atan2 } = Math;
const env = {
  log, cos, sin, exp, pow, atan2, erf: NaN, __linear_memory: memory,
  __stack_pointer: new WebAssembly.Global({ value: "i32", mutable: true }, first),
  __indirect_function_table: new WebAssembly.Table({ initial: 1, element: "anyfunc" }),
};
const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
const { instance } = await WebAssembly.instantiate(bytes(module), { env });
new Uint8Array(memory.buffer).set(bytes(content), first);
instance.exports.tabulate(...given.map((each) => (typeof each === "string" ? BigInt(each) : each)));
return Array.from(new Uint8Array(memory.buffer).subarray(at, at + size));
"""


@lean_kernel
def tabulate(angles: Floats, key: int, out: Floats) -> None:
    for i in range(angles.shape[0]):
        out[i, 0], out[i, 1] = sin_cos(angles[i])
        out[i, 2] = decay(-abs(angles[i]))
        out[i, 3], _, _, _ = uniform4(np.uint64(key), 3, i, 7)
        out[i, 4] = math.sqrt(abs(angles[i])) / 3.0
        out[i, 5] = math.floor(angles[i]) % 7


@lean_kernel
def tangents(angles: Floats) -> None:
    for i in range(angles.shape[0]):
        angles[i] = math.tan(angles[i])


@lean_kernel
def swapped(one: Floats, other: Floats, which: Ints) -> None:
    """A pair of arrays that changes in a loop is kept in memory."""
    pair = (one, other)
    for i in range(which.shape[0]):
        pair[which[i]][0] += 1.0
        pair = (pair[1], pair[which[i]])


def in_browser(browser: Any, arguments: tuple[Any, ...], out: Floats) -> bytes:
    image = Image()
    given = image.arguments(*arguments)
    values = {
        "module": base64.b64encode(compiled({"tabulate": Kernel(tabulate, arguments)})).decode(),
        "content": base64.b64encode(image.content()).decode(),
        "given": given, "first": FIRST, "at": image.address(out), "size": out.nbytes,
    }  # fmt: skip
    browser.open("about:blank", 300, 300)
    constants = "".join(f"const {name} = {json.dumps(value)};" for name, value in values.items())
    return bytes(browser.run(constants + RUN))


def test_a_kernel_has_the_same_bits_in_a_browser(browser: Any) -> None:
    angles, out = np.random.default_rng(1).normal(0.0, 30.0, COUNT), np.zeros((COUNT, 6))
    found = in_browser(browser, (angles, 5, out), out)
    tabulate(angles, 5, out)
    assert np.abs(out).min(axis=1).max() > 0.0
    assert found == out.tobytes()


def test_what_a_browser_does_not_have_is_refused() -> None:
    with pytest.raises(InvalidInput, match="kernels: need tan"):
        compiled({"tangents": Kernel(tangents, (np.zeros(3),))})


def test_a_kernel_that_keeps_an_address_in_memory_is_refused() -> None:
    with pytest.raises(InvalidInput, match="keeps an address in memory"):
        compiled({"swapped": Kernel(swapped, (np.zeros(3), np.zeros(3), np.zeros(2, np.int64)))})


def test_arrays_have_places_of_their_own_behind_those_that_are_shared() -> None:
    one, other = np.arange(3.0), np.arange(5)
    shared = Image()
    shared.address(one)
    image = Image(shared)
    arguments = image.arguments(one, (other, 2.5, True), 7)
    assert image.address(one) == shared.first == FIRST
    assert image.address(other) == image.first == shared.end == FIRST + 32
    assert arguments[2:] == [
        0, 0, "3", "8", FIRST, "3", "8", 0, 0, "5", "8", FIRST + 32, "5", "8", 2.5, 1, "7",
    ]  # fmt: skip
    assert image.content() == other.tobytes() + bytes(8)


def test_an_array_with_gaps_is_refused() -> None:
    with pytest.raises(InvalidInput, match="allowed are contiguous"):
        Image().address(np.zeros((4, 4))[:, 1])
