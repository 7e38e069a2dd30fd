from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt
import pytest

from hazbot_gym.core.discomfort import discomfort, facing
from hazbot_gym.core.proxemics import intrusion_depth
from hazbot_gym.core.state import as_record
from hazbot_gym.policies.mpc_plan import LEVELS, Problem, plan
from hazbot_gym.policies.people_seen import RADII_M

STAGES = 4
PROBLEM = Problem(
    stages=STAGES,
    stage_s=0.7,
    unit_m=0.035,
    most_down=2,
    progress=0.2,
    smoothness=0.05,
    intrusion=3.0,
    contact=20.0,
    is_rated=False,
)
PROBLEMS = (PROBLEM, PROBLEM._replace(is_rated=True))
PLACES = 2 * LEVELS * STAGES + 1
WAY = np.stack([np.arange(PLACES) * PROBLEM.unit_m, 0.1 * np.arange(PLACES) * PROBLEM.unit_m])


def first_of_plan(
    people: npt.ArrayLike, speed: float, command: float, problem: Problem = PROBLEM
) -> float:
    out = np.zeros(1)
    plan(
        np.asarray(people, dtype=float)[None],
        WAY[None],
        np.array([speed]),
        np.array([command]),
        as_record(problem),
        np.zeros((2, LEVELS + 1, PLACES)),
        np.zeros((2, PLACES)),
        out,
    )
    return float(out[0])


def value(
    levels: tuple[int, ...], people: npt.NDArray[np.float64], command: float, problem: Problem
) -> float:
    """Return the reward of a plan, one stage after the other."""
    place, earned = 0, 0.0
    for t in range(1, STAGES + 1):
        i, j = levels[t - 1], levels[t]
        place += i + j
        x, y = people[:2] + people[2:4] * t * PROBLEM.stage_s
        dx, dy = WAY[0, place] - x, WAY[1, place] - y
        clearances_m = np.hypot(dx, dy) - RADII_M
        near = intrusion_depth(float(clearances_m.min())) * j / LEVELS
        if problem.is_rated:
            toward = map(facing, dx, dy, people[2], people[3])
            near = max(map(discomfort, clearances_m, toward)) * (j / LEVELS) ** 2
        before = command if t == 1 else i
        earned -= problem.intrusion * near + PROBLEM.smoothness * (j - before) ** 2
        earned -= PROBLEM.contact * (clearances_m.min() < 0.0) * j / LEVELS
    return earned + PROBLEM.progress * place


def plans(level: int) -> list[tuple[int, ...]]:
    """Return all plans that the limits allow."""
    return [
        (level, *rest)
        for rest in itertools.product(range(LEVELS + 1), repeat=STAGES)
        if all(-2 <= b - a <= 1 for a, b in itertools.pairwise((level, *rest)))
    ]


@pytest.mark.parametrize("problem", PROBLEMS)
def test_plan_begins_as_the_best_of_all_plans(problem: Problem) -> None:
    rng, changes = np.random.default_rng(0), set()
    for level, _ in itertools.product(range(LEVELS + 1), range(10)):
        low, high = [[0.0], [-2.5], [-1.0], [-0.5]], [[4.0], [2.5], [0.5], [0.5]]
        people = np.vstack([rng.uniform(low, high, (4, 2)), np.ones(2)])
        command = float(rng.uniform(0.0, LEVELS))
        earned = {levels: value(levels, people, command, problem) for levels in plans(level)}
        best = max(earned, key=earned.__getitem__)
        changes.add(best[1] - level)
        first = first_of_plan(people, level / LEVELS, command / LEVELS, problem)
        assert first == best[1] / LEVELS
    assert changes == {-2, -1, 0, 1}


def test_who_is_not_there_is_not_avoided() -> None:
    in_the_way = [0.3, 0.0, 0.0, 0.0]
    there, gone = (np.array([[*in_the_way, is_there]]).T for is_there in (1.0, 0.0))
    assert first_of_plan(there, 1.0, 1.0) < first_of_plan(gone, 1.0, 1.0) == 1.0


@pytest.mark.parametrize("speed", [-0.2, 0.0, 1.0, 1.3])
def test_speeds_beyond_the_lattice_count_as_its_ends(speed: float) -> None:
    nobody = np.zeros((5, 1))
    expected = min(max(speed, 0.0) + 1.0 / LEVELS, 1.0)
    assert first_of_plan(nobody, speed, expected) == pytest.approx(expected)
