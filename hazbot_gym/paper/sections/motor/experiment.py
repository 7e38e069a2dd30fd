"""Motor identification from the paper's figures of the circle (A11, docs/paper.md).

The paper prints no motor. The search minimizes the largest relative deviation from the paper's
figures over the six parameters of a plant: of the fuzzy-PID's four figures alone, and of all eight,
including those of the PID on the same plant.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.pid import Plant
from hazbot_gym.core.state import Floats
from hazbot_gym.paper.evolution import search
from hazbot_gym.paper.sections.circle.experiment import Figures, reported_figures
from hazbot_gym.paper.sections.circle.variants import LOOPS, on_plant

# Search bounds. A mismatch of 0.5 makes one motor three times as strong as the other; an extra lag
# below a physics step has no effect.
RATES = {"K": (0.2, 10.0), "T1": (0.2, 10.0), "Tf": (0.01, 0.3)}  # by their logarithm
LEVELS = {"T2": (0.01, 0.5), "a": (-0.5, 0.5)}
TIGHTEST_U, FREE_SHARE = 10.0, 0.05  # of u_max; the share of the search without a bound
NUMBERS = len(RATES) + len(LEVELS) + 1


class Nearest(NamedTuple):
    """The plant closest to some of the paper's figures."""

    plant: Plant
    tries: int  # evaluated plants
    miss: float  # largest relative difference among the figures searched for
    found: dict[str, Figures]  # figures on this plant, by controller


def plant_of(shares: Floats) -> Plant:
    """Return the plant of six numbers in [0, 1]."""
    rates, levels, (tightness,) = np.split(shares, (len(RATES), len(RATES) + len(LEVELS)))
    values = {
        name: float(low * (high / low) ** share)
        for (name, (low, high)), share in zip(RATES.items(), rates, strict=True)
    }
    values |= {
        name: float(low + (high - low) * share)
        for (name, (low, high)), share in zip(LEVELS.items(), levels, strict=True)
    }
    return Plant(**values, u_max=float(TIGHTEST_U / tightness) if tightness > FREE_SHARE else 0.0)


def differences(plant: Plant, controllers: Sequence[str]) -> Floats:
    """Return the relative differences from the paper's figures: (controllers, 4)."""
    return np.array([np.divide(on_plant(plant, c), reported_figures(c)) - 1.0 for c in controllers])


def nearest(controllers: Sequence[str], *, generations: int, seed: int) -> Nearest:
    """Search the plant on which these controllers come closest to the paper's figures."""
    found = search(
        lambda shares: float(np.abs(differences(plant_of(shares), controllers)).max()),
        NUMBERS,
        generations=generations,
        seed=seed,
    )
    plant = plant_of(found.shares)
    return Nearest(plant, found.tries, found.cost, {name: on_plant(plant, name) for name in LOOPS})
