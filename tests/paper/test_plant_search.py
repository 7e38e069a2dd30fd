"""The paper's motor, searched by its eight figures."""

from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.core.pid import PLANTS, Plant
from hazbot_gym.paper.evolution import MEMBERS, search
from hazbot_gym.paper.sections.circle.experiment import FIGURE_NAMES
from hazbot_gym.paper.sections.circle.variants import LOOPS
from hazbot_gym.paper.sections.motor.experiment import (
    LEVELS,
    NUMBERS,
    RATES,
    TIGHTEST_U,
    differences,
    nearest,
    plant_of,
)

BOTH = tuple(LOOPS)
# As a search found it, rounded: unlike plant B, and as near to the paper's fuzzy-PID.
ANOTHER = Plant(K=2.136, T1=0.93, T2=0.298, Tf=0.07, a=-0.211, u_max=11.291)


def test_search_finds_the_least_cost_within_its_budget_and_survives_what_cannot_be_judged() -> None:
    asked = []

    def cost(shares: np.ndarray) -> float:
        asked.append(shares)
        return float("nan") if shares[0] > 0.9 else float(np.abs(shares - 0.25).sum())

    found = search(cost, 2, generations=20, seed=3)
    assert found.shares == pytest.approx([0.25, 0.25], abs=0.01)
    assert found.tries == len(asked) == 21 * MEMBERS
    assert found.cost == pytest.approx(cost(found.shares))


def test_every_plant_is_within_what_is_searched() -> None:
    lowest, highest = plant_of(np.zeros(NUMBERS)), plant_of(np.ones(NUMBERS))
    for name, (low, high) in (RATES | LEVELS).items():
        assert getattr(lowest, name) == pytest.approx(low)
        assert getattr(highest, name) == pytest.approx(high)
    assert lowest.u_max == 0.0  # no bound
    assert highest.u_max == TIGHTEST_U
    assert len(Plant._fields) == NUMBERS


def test_differences_are_relative_to_the_paper() -> None:
    found = differences(PLANTS["B"], BOTH)
    assert found.shape == (2, len(FIGURE_NAMES))
    assert found[1, 0] == pytest.approx(0.1423 / 0.1 - 1.0, abs=0.001)
    assert np.abs(found[0]).max() < 0.1  # the tolerance of a fit


def test_a_search_comes_nearer_the_longer_it_is_and_is_the_same_again() -> None:
    short, longer = (nearest(BOTH, generations=g, seed=0) for g in (0, 6))
    assert longer.miss < short.miss
    assert longer.miss == pytest.approx(np.abs(differences(longer.plant, BOTH)).max())
    assert longer.tries == 7 * MEMBERS
    assert nearest(BOTH, generations=0, seed=0) == short


def test_four_figures_confirm_no_motor() -> None:
    fuzzy, pid = differences(ANOTHER, BOTH)
    assert np.abs(fuzzy).max() < 0.02
    assert np.abs(pid).max() > 0.4
