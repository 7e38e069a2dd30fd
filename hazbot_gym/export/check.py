"""Exports run beside the policy in Python, observation by observation."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hazbot_gym.errors import MissingExtra
from hazbot_gym.export.plan import Plan
from hazbot_gym.policies.guard import Observations

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
ROOM = 1024  # words for the echoes of any ring in ``hazbot_memory``
Actions = npt.NDArray[np.float32]


def onnx_actions(
    plan: Plan, model: bytes, observations: Observations, starts: npt.NDArray[np.bool_]
) -> Actions:
    """Return the actions of an ONNX file on observations one after another, (N,)."""
    try:
        import onnxruntime
    except ImportError as error:
        raise MissingExtra("onnxruntime", "export") from error
    session = onnxruntime.InferenceSession(model, providers=["CPUExecutionProvider"])
    if not plan.memory:
        actions: Actions = session.run(["action"], {"observation": observations})[0][:, 0]
        return actions
    zeros = np.zeros((1, plan.memory), np.float32)
    state, found = [zeros, zeros], []
    for row, begins in zip(observations[:, None], starts, strict=True):
        hidden, cell = (zeros, zeros) if begins else state
        action, *state = session.run(
            ["action", "next_hidden", "next_cell"],
            {"observation": row, "hidden": hidden, "cell": cell},
        )
        found.append(action[0, 0])
    return np.array(found, np.float32)


def c_actions(
    plan: Plan,
    folder: Path,
    observations: Observations,
    starts: npt.NDArray[np.bool_],
    compiler: str = "gcc",
) -> Actions:
    """Return the actions of compiled C on observations one after another, (N,)."""
    with tempfile.TemporaryDirectory() as build:
        library = Path(build, "policy.so")
        command = [compiler, *STRICT, "-O2", "-shared", "-fPIC", "-o", str(library)]
        subprocess.run([*command, str(folder / "hazbot_policy.c")], check=True)
        compiled = ctypes.CDLL(str(library))
    compiled.hazbot_act.restype = ctypes.c_float
    memory = (ctypes.c_double * (ROOM + plan.memory))()
    more = (memory,) if plan.has_memory else ()
    rows = np.ascontiguousarray(observations, np.float32)
    found = []
    for row, begins in zip(rows, starts, strict=True):
        if begins and plan.has_memory:
            compiled.hazbot_reset(memory)
        found.append(compiled.hazbot_act(row.ctypes.data_as(ctypes.c_void_p), *more))
    return np.array(found, np.float32)
