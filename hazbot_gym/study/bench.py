"""How fast the environment steps, measured beside Gymnasium's CartPole-v1 in the same run.

A speed by itself says little about code and much about the machine, so what counts is the ratio.
The two are measured in turns, so that another load on the machine meets both.
"""

from __future__ import annotations

import statistics
import time
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from rich.console import Group
from rich.table import Table

from hazbot_gym.study import provenance

CARTPOLE = "CartPole-v1"
CORRIDOR = "hazbot_gym/Corridor-v0"
WHAT = "4 social-force people, ultrasonic ranges, people tracker, fuzzy-PID wheel loops"
OVERRIDES: dict[str, Any] = {"people": {"model": "social_force", "count": [4, 4]}}


class Effort(NamedTuple):
    """How long to measure: number of turns, and steps of each environment in a turn."""

    turns: int
    corridor_steps: int
    cartpole_steps: int


FULL = Effort(turns=9, corridor_steps=4_000, cartpole_steps=20_000)
QUICK = Effort(turns=3, corridor_steps=500, cartpole_steps=2_000)


def bench(effort: Effort = FULL) -> dict[str, Any]:
    """Measure steps per second of both environments, and return medians, spread and ratio."""
    corridor = Stepper(gymnasium.make(CORRIDOR, **OVERRIDES))
    cartpole = Stepper(gymnasium.make(CARTPOLE))
    for stepper in (corridor, cartpole):
        stepper.run(200)  # compiles or loads kernels
    turns = [
        (corridor.rate(effort.corridor_steps), cartpole.rate(effort.cartpole_steps))
        for _ in range(effort.turns)
    ]
    ours, theirs = zip(*turns, strict=True)
    return {
        CORRIDOR: _rates(ours, effort.corridor_steps) | {"with": WHAT},
        CARTPOLE: _rates(theirs, effort.cartpole_steps),
        "ratio": statistics.median(a / b for a, b in turns),
        "what": "gymnasium.make, random actions, resets included, one process",
        "machine": provenance.machine(),
    }


def table(result: dict[str, Any]) -> Group:
    """Return what ``bench`` measured as a table, and below it what exactly was measured."""
    turns = result[CORRIDOR]["turns"]
    shown = Table(box=None, pad_edge=False)
    shown.add_column(f"median (quartiles) of {turns} turns")
    shown.add_column("steps/s", justify="right")
    for name in (CORRIDOR, CARTPOLE):
        median, (low, high) = result[name]["steps_per_s"], result[name]["steps_per_s_quartiles"]
        shown.add_row(name, f"{median:,.0f} ({low:,.0f} to {high:,.0f})")
    shown.add_row("ratio", f"{result['ratio']:.3f}")
    machine = result["machine"]
    return Group(
        shown,
        f"{CORRIDOR} with {WHAT}",
        result["what"],
        f"{machine['processor']}, {machine['cores']} cores, Python {machine['python']}",
    )


class Stepper:
    """Steps an environment with random actions drawn beforehand, and resets it where it ends."""

    def __init__(self, env: gymnasium.Env[Any, Any], seed: int = 0) -> None:
        self.env = env
        env.action_space.seed(seed)
        self.actions = [env.action_space.sample() for _ in range(1000)]
        env.reset(seed=seed)

    def run(self, steps: int) -> None:
        """Take a number of steps, going on from where the last run stopped."""
        step, reset, actions = self.env.step, self.env.reset, self.actions
        for k in range(steps):
            _, _, terminated, truncated, _ = step(actions[k % 1000])
            if terminated or truncated:
                reset()

    def rate(self, steps: int) -> float:
        """Return steps per second over a number of steps."""
        start = time.perf_counter()
        self.run(steps)
        return steps / (time.perf_counter() - start)


def _rates(rates: tuple[float, ...], steps: int) -> dict[str, Any]:
    quartiles = np.percentile(rates, [25, 50, 75])
    return {
        "steps_per_s": float(quartiles[1]),
        "steps_per_s_quartiles": [float(quartiles[0]), float(quartiles[2])],
        "turns": len(rates),
        "steps_a_turn": steps,
    }
