"""Export benchmark: equality with Python, and size and instructions on an emulated Cortex-M3.

The paper's robot has an STM32F103, a Cortex-M3 without floating point at 72 MHz. QEMU emulates one
(mps2-an385) and counts instructions, not cycles: flash wait states, branches and divisions take
more than one cycle each. Debian: ``gcc-arm-none-eabi`` and ``qemu-system-arm``.
"""

from __future__ import annotations

import itertools
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from hazbot_gym.errors import InvalidInput
from hazbot_gym.export.check import STRICT, c_actions, onnx_actions
from hazbot_gym.export.golden import COUNT, actions_of, observations_for
from hazbot_gym.export.plan import plan_of
from hazbot_gym.export.write import ONNX, export
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import describe, write
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.lstm import Lstm
from hazbot_gym.task.observation import LAYOUTS
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, console_table, shown

COMPILER, EMULATOR = "arm-none-eabi-gcc", "qemu-system-arm"
TARGET = ("-mcpu=cortex-m3", "-mthumb", "-ffreestanding", "-O2", "-ffunction-sections")
LINK = ("-nostdlib", "-static", "-Wl,--gc-sections,-u,hazbot_encode,-u,hazbot_speed_mps")
BOARD = ("-M", "mps2-an385", "-nographic", "-icount", "shift=0")
HOST = ("-semihosting-config", "enable=on,target=native")
LOOPS = 1_000_000  # of two instructions, in the calibration of measure.c
CLOCK_HZ = 72e6  # of the STM32F103
OBSERVATIONS = 10_000
EQUAL = ("policy", "observations", "C99, largest difference", "ONNX, largest difference")
SIZES = (
    "policy", "flash, kB", "of which weights, kB", "memory between decisions, bytes",
    "stack, bytes", "most instructions", "ms at 72 MHz, 1 to 2 cycles each",
)  # fmt: skip
Record = JsonObject


def tools() -> list[str]:
    """Return the names of the programs that are missing."""
    return [name for name in (COMPILER, EMULATOR, "gcc") if shutil.which(name) is None]


def bench_export() -> Record:
    """Measure all cases.

    Raises:
        InvalidInput: A program is missing.
    """
    if missing := tools():
        raise InvalidInput(
            f"export: {missing[0]} is not installed (Debian: {_package(missing[0])})"
        )
    with tempfile.TemporaryDirectory() as folder:
        cases = {
            name: measure(spec, tier, Path(folder, f"case{i}"))
            for i, (name, spec, tier) in enumerate(_cases(Path(folder)))
        }
    return {
        "cases": cases,
        "observations": OBSERVATIONS,
        "golden": COUNT,
        "compiler": _version(COMPILER),
        "options": " ".join(TARGET),
        "emulator": _version(EMULATOR),
    }


def _package(program: str) -> str:
    return {COMPILER: "gcc-arm-none-eabi"}.get(program, program)


def _version(program: str) -> str:
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[0]


def _cases(folder: Path) -> Iterator[tuple[str, str, str]]:
    """Yield name, spec and tier of each case; random networks are written into the folder."""
    for tier in ("tracks", "sonar"):
        yield f"`fuzzy_expert`, {tier}", "fuzzy_expert", tier
    for tier, base in (("tracks", ""), ("sonar", " on `ssm:mode=strict`")):
        yield f"`ppo`, {tier}: {LAYOUTS[tier].width}-96-96-1{base}", "ppo", tier
    mlp, lstm = folder / "mlp.npz", folder / "lstm.npz"
    yield "MLP, sonar: 12-64-64-1, tanh", f"learned:path={_random(mlp, (64, 64))}", "sonar"
    yield "LSTM, sonar: 12-LSTM 64-1", f"learned:path={_random(lstm, (), lstm=64)}", "sonar"


def _random(file: Path, hidden: tuple[int, ...], lstm: int = 0) -> Path:
    """Write an actor of the tier sonar with random weights."""
    rng, width = np.random.default_rng(0), 12

    def layer(inputs: int, outputs: int) -> Layer:
        weight = rng.normal(size=(inputs, outputs)) / np.sqrt(inputs)
        return Layer(weight.astype(np.float32), np.zeros(outputs, np.float32))

    memory = Lstm(layer(width + lstm, 4 * lstm)) if lstm else None
    layers = tuple(layer(*pair) for pair in itertools.pairwise((lstm or width, *hidden, 1)))
    actor = Actor(layers, "tanh", "clipped", lstm=memory)
    with file.open("wb") as opened:
        write(describe(actor, algorithm="random", tier="sonar"), opened)
    return file


def measure(spec: str, tier: str, folder: Path) -> Record:
    """Export a policy and return what is measured of it."""
    plan = plan_of(spec, tier)
    observations = observations_for(plan, OBSERVATIONS, seed=1)
    starts = np.arange(OBSERVATIONS) % 100 == 0
    expected = actions_of(plan, observations, starts)
    export(spec, "c", folder, tier=tier)
    found = {"c": c_actions(plan, folder, observations, starts)}
    if plan.actor is not None and not plan.listens:
        export(spec, "onnx", folder / "onnx", tier=tier)
        model = (folder / "onnx" / ONNX).read_bytes()
        found["onnx"] = onnx_actions(plan, model, observations, starts)
    weights = 0
    if plan.actor is not None:
        gates = (plan.actor.lstm.gates,) if plan.actor.lstm else ()
        weights = sum(each.nbytes for layer in (*plan.actor.layers, *gates) for each in layer)
    return {
        "difference": {
            name: float(np.abs(actions - expected).max()) for name, actions in found.items()
        },
        "weight_bytes": weights,
        **on_cortex_m3(folder),
    }


def on_cortex_m3(folder: Path) -> Record:
    """Compile the C of an export for a Cortex-M3 and run its golden vectors in the emulator."""
    harness = resources.files("hazbot_gym.bench") / "cortex_m3"
    with resources.as_file(harness) as board:
        sources = {
            "policy": folder / "hazbot_policy.c",
            "measure": board / "measure.c",
            "start": board / "start.c",
        }
        objects = {name: folder / f"{name}.o" for name in sources}
        for name, source in sources.items():
            strict = STRICT if name == "policy" else ("-std=gnu11", "-Wall")
            where = ("-I", str(folder), "-c", str(source), "-o", str(objects[name]))
            subprocess.run([COMPILER, *TARGET, *strict, *where], check=True)
        program, files = folder / "program.elf", [str(each) for each in objects.values()]
        script = ("-T", str(board / "board.ld"), "-o", str(program))
        subprocess.run([COMPILER, *TARGET, *LINK, *script, *files, "-lgcc"], check=True)
    policy, whole = _size(objects["policy"]), _size(program)
    others = _size(objects["measure"])[0] + _size(objects["start"])[0]
    run = _emulate(program)
    per_tick = 2.0 * LOOPS / run["calibration"]
    return {
        "flash_bytes": whole[0] - others,  # with the compiler's arithmetic
        "object_flash_bytes": policy[0],
        "ram_bytes": policy[1],
        "memory_bytes": run.get("memory", 0),
        "stack_bytes": run["stack"],
        "instructions": round(run["ticks"] * per_tick),
        "instructions_a_tick": per_tick,
        "golden_difference": run["difference_e9"] * 1e-9,
    }


def _size(file: Path) -> tuple[int, int]:
    """Return the bytes in flash and in RAM of an object or a program."""
    size = COMPILER.replace("gcc", "size")
    done = subprocess.run([size, str(file)], capture_output=True, text=True, check=True)
    text, data, bss = map(int, done.stdout.splitlines()[1].split()[:3])
    return text + data, data + bss


def _emulate(program: Path) -> dict[str, int]:
    command = [EMULATOR, *BOARD, *HOST, "-kernel", str(program)]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL
    )
    said = done.stdout + done.stderr
    if done.returncode != 0:
        raise RuntimeError(f"{program.name} ended with {done.returncode}: {said}")
    return {name: int(value) for name, value in re.findall(r"(\w+)=(\d+)", said)}


def equality_rows(record: Record) -> Rows:
    """Return the largest differences from Python."""
    count = f"{record['observations']:,}"
    return [
        (name, count, *(_difference(case["difference"].get(kind)) for kind in ("c", "onnx")))
        for name, case in record["cases"].items()
    ]


def _difference(value: float | None) -> str:
    return "-" if value is None else f"{value:.1e}" if value else "0"


def size_rows(record: Record) -> Rows:
    """Return sizes and instructions."""
    return [
        (
            name,
            shown(case["flash_bytes"] / 1000.0),
            shown(case["weight_bytes"] / 1000.0),
            str(case["memory_bytes"]),
            str(case["stack_bytes"]),
            f"{case['instructions']:,}",
            " to ".join(shown(1e3 * case["instructions"] * k / CLOCK_HZ) for k in (1, 2)),
        )
        for name, case in record["cases"].items()
    ]


def tables(record: Record) -> list[Any]:
    """Return a record as tables for the terminal."""
    return [
        console_table(EQUAL, equality_rows(record)),
        console_table(SIZES, size_rows(record)),
    ]
