"""The loops over lanes are vector instructions: nothing else tells if a change undoes that."""

from __future__ import annotations

import platform
import re
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import pytest

from hazbot_gym.config import make_config
from hazbot_gym.core.social_force import SocialForce
from hazbot_gym.core.state import as_record, records
from hazbot_gym.sim import lanes, walkers
from hazbot_gym.sim.drive import drive_parameters
from hazbot_gym.sim.lanes import DRIVE_LANES, drive_values
from hazbot_gym.sim.walkers import force_values, make_workspace

pytestmark = pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64"), reason="reads x86-64 instructions"
)
DRIVE = as_record(drive_parameters(make_config().drive, 0.01))
FORCE = as_record(SocialForce())


def packed_share(function: Callable[..., Any], *arguments: Any) -> float:
    """Return the share of packed ones among a function's products, sums and quotients."""
    compiled = numba.njit(error_model="numpy", _nrt=False)(function)
    compiled(*arguments)
    (assembly,) = compiled.inspect_asm().values()
    packed, single = (len(re.findall(rf"v?(mul|add|sub|div){x}\s", assembly)) for x in ("pd", "sd"))
    return packed / (packed + single)


@pytest.mark.parametrize("name", ["_disturb", "_steer", "_roll"])
def test_robots_are_driven_in_vectors(name: str) -> None:
    step = getattr(lanes, name)

    def driven(group: Any, parameters: Any) -> None:
        step(group[0], drive_values(parameters[0]))

    assert packed_share(driven, records(DRIVE_LANES, 1), DRIVE) > 0.9


@pytest.mark.skipif(
    numba.version_info.short < (0, 62), reason="numba before 0.62 makes no vectors of this loop"
)
def test_walkers_choose_in_vectors() -> None:
    choose = walkers._choose

    def chosen(chunks: Any, force: Any) -> None:
        choose(chunks[0], force_values(force[0]), 0.05)

    # What does not depend on the walker is worked out once, before the loops.
    assert packed_share(chosen, make_workspace(1).walkers, FORCE) > 0.8


def test_a_loop_that_calls_something_is_told_apart() -> None:
    def sines(values: Any, out: Any) -> None:
        for i in range(values.shape[0]):
            out[i] = 3.0 * np.sin(values[i]) + 1.0

    # Below the least that is asked of loops in vectors; numba 0.61 packs what is around the call.
    assert packed_share(sines, np.zeros(16), np.zeros(16)) < 0.8
