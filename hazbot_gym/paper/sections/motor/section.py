"""Section 5.2, continued: motor identification from the paper's eight figures."""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.pid import PLANTS, Plant
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.numbers import reported
from hazbot_gym.paper.sections.circle import plots
from hazbot_gym.paper.sections.circle.section import figure_table
from hazbot_gym.paper.sections.circle.variants import LOOPS
from hazbot_gym.paper.sections.motor.experiment import LEVELS, Nearest, differences, nearest

AIMS = {"the fuzzy-PID's four": ("fuzzy-PID",), "all eight": tuple(LOOPS)}
FIT = reported().rules["motor"].tolerance_for(1.0)  # as a share
GENERATIONS, SEARCHES = 62, 2  # of each search, and how many for each aim

Searched = dict[str, list[Nearest]]  # by aim


def chapter(quick: bool) -> Chapter:
    """Run the section; the paper reports no number of it."""
    generations = 2 if quick else GENERATIONS
    searched = {
        aim: [nearest(controllers, generations=generations, seed=seed) for seed in range(SEARCHES)]
        for aim, controllers in AIMS.items()
    }
    named = {
        f"{aim}, search {number}": found
        for aim, each in searched.items()
        for number, found in enumerate(each, start=1)
    }
    return Chapter(
        number="5.2a",
        title="Motor identification from the eight figures",
        here={},
        record={name: _record(found) for name, found in named.items()},
        text=_text(searched),
        tables=(
            _plant_table(named),
            figure_table(
                "Figures of these plants, compared with the paper",
                {
                    f"{name}, {controller}": four
                    for name, found in named.items()
                    for controller, four in found.found.items()
                },
            ),
        ),
        pictures=(
            Picture(
                "motor-misses",
                "",
                "Differences from the eight figures of section 5.2 on plant B and on the plants "
                "found; gray: the tolerance for a fit.",
                plots.misses(
                    {
                        name: differences(plant, tuple(LOOPS))
                        for name, plant in {
                            "plant B": PLANTS["B"],
                            **{name: found.plant for name, found in named.items()},
                        }.items()
                    },
                    FIT,
                ),
            ),
        ),
    )


def _record(found: Nearest) -> dict[str, object]:
    return found._asdict() | {
        "plant": found.plant._asdict(),
        "found": {controller: four._asdict() for controller, four in found.found.items()},
    }


def _text(searched: Searched) -> tuple[str, ...]:
    four, eight = searched.values()
    tries = sum(found.tries for each in searched.values() for found in each)
    best, worst = min(found.miss for found in eight), max(found.miss for found in four)
    unlike = max(_times_as_strong(found.plant.a) for found in eight)
    of_pid = max(_off(found.plant, "PID") for found in four)
    b = PLANTS["B"]
    conclusion = (
        ", so the figures do not identify the motor"
        if worst <= FIT
        else "; a longer search may come closer"
    )
    return (
        f"The paper does not specify the motor, so {tries} plants were tried. Differential "
        "evolution searched all six parameters of a plant for the smallest maximum relative "
        "difference from the paper's figures. The four figures of the fuzzy-PID are met within "
        f"{100.0 * worst:.1f} % by motors with gains K = {_listed(four, 'K')} and time constants "
        f"of {_listed(four, 'T1')} s, and within {100.0 * _off(b, 'fuzzy-PID'):.0f} % by plant B "
        f"with K = {b.K:g} and {b.T1:g} s{conclusion}. On the plants found, the PID is off by up "
        f"to {100.0 * of_pid:.0f} %.",
        f"The plant closest to all eight figures differs by {100.0 * best:.0f} %, where the "
        f"tolerance for a fit is {100.0 * FIT:.0f} %. Plant C, the closest that an earlier "
        f"prototype found, differs by {100.0 * _off(PLANTS['C'], *LOOPS):.0f} %. In the "
        f"plants found for all eight figures, one motor is up to {unlike:.1f} times as strong as "
        "the other; a ratio of up to "
        f"{_times_as_strong(LEVELS['a'][1]):.0f} was allowed. Within these bounds, no motor of "
        "this kind was found that gives the figures that the paper reports for both controllers.",
    )


def _off(plant: Plant, *controllers: str) -> float:
    """Return the largest relative difference from the paper's figures on a plant."""
    return float(np.abs(differences(plant, controllers)).max())


def _listed(found: list[Nearest], name: str) -> str:
    return " and ".join(f"{getattr(each.plant, name):.2g}" for each in found)


def _times_as_strong(mismatch: float) -> float:
    """Return the gain ratio of the stronger to the weaker motor."""
    return (1.0 + abs(mismatch)) / (1.0 - abs(mismatch))


def _plant_table(named: dict[str, Nearest]) -> Table:
    return Table(
        "The plants found, by the figures they were fitted to",
        ("fitted to", "K", "T1 [s]", "T2 [s]", "Tf [s]", "a", "u_max", "largest difference"),
        [
            (name, *_shown(found.plant), f"{100.0 * found.miss:.1f} %")
            for name, found in named.items()
        ],
    )


def _shown(plant: Plant) -> tuple[str, ...]:
    numbers = (f"{value:.3g}" for value in plant[:-1])
    return (*numbers, f"{plant.u_max:.3g}" if plant.u_max else "none")
