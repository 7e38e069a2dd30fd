"""Measure what hooks cost who uses none: ``python docs/make_hooks_record.py``.

Each engine is stepped without hooks, with some that are registered but not in use, and with a
reward term of weight 0, in turns in one process. Times are those of the processor, so that other
load on the machine matters little. Writes ``benchmarks/hooks.json``; a minute.
"""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable
from pathlib import Path

import gymnasium
import numpy as np

from hazbot_gym import pedestrian_model, reward_term
from hazbot_gym.bench.cases import CORRIDOR, DRAWN, CorridorStepper, Stepper, with_people
from hazbot_gym.bench.once import spread_of
from hazbot_gym.core.own_walking import Situation
from hazbot_gym.core.state import PersonRecord, Records, RobotRecord
from hazbot_gym.task.step_record import Rules, StepRecord
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import write_json
from hazbot_gym.utils.json_object import JsonObject

RECORD = Path(__file__).parents[1] / "benchmarks" / "hooks.json"
TURNS, WORLDS, PEOPLE, SPREAD = 31, 1024, 4, 300
CALLS = {Stepper: 1000, CorridorStepper: 20}  # in a turn
DECISIONS = 500  # of the comparison in bits
NONE, UNUSED, ZERO = "no hooks", "hooks registered, not in use", "own reward term of weight 0"
Stepped = Stepper | CorridorStepper


ENGINES: dict[str, Callable[..., Stepped]] = {
    "one environment": lambda **hooks: Stepper(
        gymnasium.make(CORRIDOR, **with_people(PEOPLE), **hooks)
    ),
    f"batch of {WORLDS:,}, one thread": lambda **hooks: CorridorStepper(
        WORLDS, PEOPLE, spread=SPREAD, threads=1, **hooks
    ),
}


def record() -> JsonObject:
    """Return the record: speeds, ratios to no hooks, and whether all numbers are the same."""
    load = os.getloadavg()[0]
    for make in ENGINES.values():
        make()  # Python steps the first of a kind faster, by a sixth
    cases = {engine: {NONE: make()} for engine, make in ENGINES.items()}
    register()
    for engine, make in ENGINES.items():
        cases[engine] |= {UNUSED: make(), ZERO: make(own_terms={"half": 0.0})}
    return {
        "commit": provenance.commit(),
        "machine": provenance.machine(),
        "load_before": load,
        "turns": TURNS,
        "decisions": DECISIONS,
        "rows": [{"engine": engine, **row} for engine, each in cases.items() for row in rows(each)],
    }


def rows(cases: dict[str, Stepped]) -> list[JsonObject]:
    """Return speed, ratio and equality of an engine's cases."""
    digests = {name: digest(case) for name, case in cases.items()}
    rates = speeds(cases)
    return [
        {
            "hooks": name,
            **spread_of(rates[name], "steps_per_s"),
            **spread_of(list(np.divide(rates[name], rates[NONE])), "to_no_hooks"),
            "is_equal": digests[name] == digests[NONE],
        }
        for name in cases
    ]


def speeds(cases: dict[str, Stepped]) -> dict[str, list[float]]:
    """Return the steps per second of processor time in each turn; who begins changes."""
    rates: dict[str, list[float]] = {name: [] for name in cases}
    for turn in range(TURNS):
        names = [*cases][turn % len(cases) :] + [*cases][: turn % len(cases)]
        for name in names:
            calls, start = CALLS[type(cases[name])], time.process_time()
            cases[name].run(calls)
            rates[name].append(cases[name].size * calls / (time.process_time() - start))
    return rates


def register() -> None:
    """Register a reward term and a pedestrian model."""

    @reward_term
    def half(robot: RobotRecord, people: Records, record: StepRecord, rules: Rules) -> float:
        """Half, whatever happens."""
        return 0.5

    @pedestrian_model
    def straight(me: PersonRecord, situation: Situation) -> tuple[float, float]:
        """Walk to the target ahead."""
        speed = me.desired_speed
        return speed * situation.ahead_x, speed * situation.ahead_y


def digest(case: Stepped) -> str:
    """Return a digest of all observations and rewards of some decisions."""
    seen = hashlib.sha256()
    for k in range(DECISIONS):
        action = case.actions[k % DRAWN]
        if isinstance(case, Stepper):
            observation, reward, terminated, truncated, _ = case.env.step(action)
            if terminated or truncated:
                case.env.reset()
        else:
            observation, reward, *_ = case.envs.step(action)
        seen.update(np.asarray(observation).tobytes() + np.asarray(reward, np.float64).tobytes())
    return seen.hexdigest()


if __name__ == "__main__":
    write_json(RECORD, record())
