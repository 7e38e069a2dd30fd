"""The runtime in a fresh process: nothing is compiled or loaded after construction."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

ANSWERS = """
import json
import numpy as np
from hazbot_gym import SpeedController
from hazbot_gym.runtime.people import Person

def answers(policy, tier):
    rng = np.random.default_rng(0)
    controller = SpeedController(policy, tier=tier, clock=lambda: 0.0)
    before = loaded()
    found = []
    for _ in range(20):
        x_m, y_m, vx_mps, vy_mps = rng.uniform(-3.0, 3.0, 4)
        people = [Person(x_m, y_m, 0.5 * vx_mps, 0.5 * vy_mps)] * rng.integers(4)
        found.append(
            controller.step(
                ranges_m=rng.uniform(0.5, 4.0, 4), speed_mps=rng.uniform(0.0, 0.5),
                yaw_rate_radps=0.0, x_e_m=0.0, y_e_m=0.0, theta_e_rad=0.0, remaining_m=5.0,
                curvature_ahead_per_m=0.0, people=people,
            )
        )
    assert loaded() == before, policy
    return found

cases = (("ppo", "sonar"), ("ppo", "tracks"), ("fuzzy_expert", "tracks"), ("ssm", "sonar"))
print(json.dumps([answers(*case) for case in cases]))
"""
WITH_NUMBA = """
import gc
from numba.core.dispatcher import Dispatcher

def loaded():
    found = [each for each in gc.get_objects() if isinstance(each, Dispatcher)]
    return sum(len(each.signatures) for each in found)
"""
WITHOUT_NUMBA = """
import sys
sys.modules["numba"] = sys.modules["llvmlite"] = None
loaded = lambda: 0
"""


def answers(preparation: str) -> list[list[float]]:
    code = preparation + ANSWERS
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found: list[list[float]] = json.loads(done.stdout)
    return found


def test_steps_load_nothing_and_without_numba_they_answer_the_same() -> None:
    compiled, plain = answers(WITH_NUMBA), answers(WITHOUT_NUMBA)

    assert [max(each) - min(each) > 0.05 for each in compiled] == [True] * 4
    for one, other in zip(compiled, plain, strict=True):
        assert one == pytest.approx(other, abs=1e-6)
