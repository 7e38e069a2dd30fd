from __future__ import annotations

import os
import subprocess
import sys

import numpy as np

from hazbot_gym.config import make_config
from hazbot_gym.core.social_force import SocialForce
from hazbot_gym.core.state import GONE, PRESENT, Records
from hazbot_gym.sim.unattended import walk_in_parts, walk_unattended
from hazbot_gym.task.scenario import ScenarioSampler

DT_S = 0.05
CHECKED = """
from hazbot_gym.config import make_config
from hazbot_gym.core.social_force import SocialForce
from hazbot_gym.sim.unattended import walk_unattended
from hazbot_gym.task.scenario import ScenarioSampler
source = ScenarioSampler(make_config(people={"model": "social_force", "count": [4, 4]}))
scenario = source.draw(7)
scenario.people["reaction"] = [0, 1, 2, 3]
walk_unattended(scenario.people, scenario.place, SocialForce(), key=1, steps=10, dt_s=0.05)
"""


def walk(model: str, *, key: int = 3, steps: int = 400) -> Records:
    source = ScenarioSampler(make_config(people={"model": model, "count": [4, 4]}))
    scenario = source.draw(7)
    return walk_unattended(
        scenario.people, scenario.place, SocialForce(), key=key, steps=steps, dt_s=DT_S
    )


def test_people_walk_at_the_velocity_that_they_show() -> None:
    seen = walk("social_force")
    before, after = seen[:-1], seen[1:]
    walking = (before["status"] == PRESENT) & (after["status"] == PRESENT)
    assert walking.sum() > 500
    np.testing.assert_allclose((before["x"] + DT_S * before["vx"])[walking], after["x"][walking])
    np.testing.assert_allclose((before["y"] + DT_S * before["vy"])[walking], after["y"][walking])


def test_scripted_people_leave_at_the_end_of_their_route() -> None:
    assert np.all(walk("scripted", steps=1200)[-1]["status"] == GONE)


def test_the_fluctuations_are_those_of_the_key() -> None:
    assert np.array_equal(walk("social_force", key=1), walk("social_force", key=1))
    assert not np.array_equal(walk("social_force", key=1), walk("social_force", key=2))


def test_a_walk_in_parts_is_the_same_walk() -> None:
    scenario = ScenarioSampler(make_config(people={"count": [4, 4]})).draw(7)
    parts = walk_in_parts(
        scenario.people, scenario.place, SocialForce(), key=3, steps=400, dt_s=DT_S, part=37
    )
    assert np.array_equal(np.concatenate(list(parts)), walk("social_force"))


def test_nothing_is_read_beyond_an_array_whatever_reactions_people_have() -> None:
    checked = {**os.environ, "NUMBA_DISABLE_JIT": "1"}  # plain Python checks every index
    done = subprocess.run(
        [sys.executable, "-c", CHECKED], env=checked, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
