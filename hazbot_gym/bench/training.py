"""Training benchmark: decisions per second beside CartPole-v1's steps, and time to the expert.

Every run is a separate ``hazbot train`` process: its time includes imports, loading of compiled
code, validations and checkpoints. Its policy is then compared with the fuzzy expert on paired
held-out episodes of its environments.
"""

from __future__ import annotations

import importlib
import json
import math
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import gymnasium

from hazbot_gym.bench.cases import CARTPOLE, Stepper
from hazbot_gym.bench.run import ratio, seconds
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation import rollout
from hazbot_gym.evaluation.statistics.pareto import AXES, dominates
from hazbot_gym.policies import own_module
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.study.summary import summarise_one
from hazbot_gym.training.config import TrainConfig, load_training, split
from hazbot_gym.training.run_folder import POLICY, RESULT
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import read_json
from hazbot_gym.utils.json_object import JsonObject

EXPERT = "fuzzy_expert"
EPISODES = 1000  # paired, split among a run's environments
ROOT = 20261127  # of their seeds
SEEDS = 5  # runs
TURNS = 3  # of the two engines, alternating
CARTPOLE_STEPS = 200_000  # of a turn
UPDATES = 30  # of a turn on the batched engine
REFERENCE_WORLDS = 8  # of pymunk, or one for each environment
KEPT = (*AXES, "return", "arrived", "contact_robot_caused")
Record = JsonObject


def bench_training(paths: list[Path], *, seeds: int = SEEDS, episodes: int = EPISODES) -> Record:
    """Measure the runs of some training files.

    Raises:
        InvalidInput: A file is no training of PPO, or cannot be trained.
        MissingExtra: Stable-Baselines3 or another part of the extra is not installed.
    """
    importlib.import_module("hazbot_gym.training.run")  # raises before any work
    configs = {path: load_training(path) for path in paths}
    for path, config in configs.items():
        if config.algorithm != "ppo":
            raise InvalidInput(
                f"training: {path.name} is given with algorithm {config.algorithm!r}, "
                "allowed is 'ppo'"
            )
        for teacher in config.teachers():
            if own_module.is_reference(teacher):
                raise InvalidInput(
                    f"training: {path.name} is given with teacher {teacher!r}, allowed are "
                    "policies of the library"
                )
            make_policy(teacher)  # with the permissions of its runs: no pickle
    load = os.getloadavg()[0]
    return {
        "runs": {
            path.name: _measure(path, config, seeds, episodes) for path, config in configs.items()
        },
        "episodes": episodes,
        "seed": ROOT,
        "load_before": load,
        "machine": provenance.machine(),
        "commit": provenance.commit(),
    }


def _measure(path: Path, config: TrainConfig, seeds: int, episodes: int) -> Record:
    expert = judge(EXPERT, config, episodes)
    runs = [learn(path, config, seed, expert, episodes) for seed in range(seeds)]
    fast = speed(path, config)
    return {
        "config": config.model_dump(mode="json"),
        "expert": expert,
        "runs": runs,
        "speed": fast,
        "goals": goals(runs, fast),
    }


def goals(runs: list[Record], speed: Record) -> Record:
    """Return goals with their limit and measured value; None if not reached."""
    peak_gb = max(run["peak_bytes"] for run in runs) / 1e9
    found = {
        "decisions a second": ("at least", 50_000.0, float(speed["batched"])),
        f"times the steps of {CARTPOLE}": ("at least", 1.0, speed["to_cartpole"]),
        "times the same PPO on pymunk": ("at least", 8, speed["ratio"]),
        "seconds to a policy not dominated by the fuzzy expert, median": (
            "at most",
            60,
            _median_s(runs, [not run["is_dominated"] for run in runs]),
        ),
        "seconds to a return above the fuzzy expert's, median": (
            "at most",
            300,
            _median_s(runs, [run["is_better_paid"] for run in runs]),
        ),
        "peak memory, GB": ("at most", 1.5, peak_gb),
    }
    return {name: {side: limit, "measured": value} for name, (side, limit, value) in found.items()}


def _median_s(runs: list[Record], has_reached: list[bool]) -> float | None:
    """Return the median time of the runs, infinite for runs that did not reach the goal."""
    seconds = [
        run["seconds"] if reached else math.inf
        for run, reached in zip(runs, has_reached, strict=True)
    ]
    median = statistics.median(seconds)
    return median if math.isfinite(median) else None


def learn(path: Path, config: TrainConfig, seed: int, expert: Record, episodes: int) -> Record:
    """Train with one seed, and compare the policy with the expert."""
    with trained(path, seed=seed) as (folder, seconds, peak_bytes):
        result = read_json(folder / RESULT)
        metrics = judge(f"learned:{folder / POLICY}", config, episodes)
    return {
        "seed": seed,
        "seconds": seconds,
        "peak_bytes": peak_bytes,
        "steps": result["steps"],
        "steps_per_s": result["steps_per_s"],
        "metrics": metrics,
        "is_dominated": dominates(expert, metrics),
        "is_better_paid": metrics["return"]["mean"] > expert["return"]["mean"],
    }


def judge(policy: str, config: TrainConfig, episodes: int) -> Record:
    """Return a policy's metrics, with intervals, over the environments of a run."""
    rows = []
    for env, count in zip(config.env, split(episodes, len(config.env)), strict=True):
        if count:
            rows += rollout.evaluate(
                policy, env, episodes=count, seed=ROOT, overrides=config.overrides
            )
    metrics = summarise_one(rows, seed=0)["metrics"]
    rate = metrics["arrived"]
    arrived = {
        name: None if value is None else 100.0 * value
        for name, value in (("mean", rate["mean"]), ("low", rate["low"]), ("high", rate["high"]))
    }
    return {**{name: metrics[name] for name in KEPT}, "arrived_percent": arrived}


def speed(path: Path, config: TrainConfig) -> Record:
    """Return decisions per second of the same PPO on the batched engine and on pymunk.

    Beside them, in each turn, the steps per second of CartPole-v1 of ``gymnasium.make`` with random
    actions and resets, without any learning. An action that is held counts for all its decisions.
    """
    cases, cartpole = speed_cases(config), Stepper(gymnasium.make(CARTPOLE))
    rates: dict[str, list[float]] = {name: [] for name in (*cases, "cartpole")}
    for _ in range(TURNS):
        rates["cartpole"].append(CARTPOLE_STEPS / seconds(cartpole, CARTPOLE_STEPS))
        for name, changes in cases.items():
            with trained(path, **changes) as (folder, _, _):
                result = read_json(folder / RESULT)
            rates[name].append(result["steps_per_s"] * config.action_repeat)
    return {
        **{name: statistics.median(each) for name, each in rates.items()},
        "ratio": ratio(rates, "batched", "pymunk"),
        "to_cartpole": ratio(rates, "batched", "cartpole"),
        "turns": TURNS,
    }


def speed_cases(config: TrainConfig) -> dict[str, Record]:
    """Return the config overrides of the two runs: updates of the same size, little else.

    The reference collects longer rollouts of fewer worlds.
    """
    update = int(config.options["n_steps"]) * config.worlds
    worlds = max(REFERENCE_WORLDS, len(config.env))
    longer = {**config.options, "n_steps": update // worlds}
    validation = {"every_steps": 10**9, "episodes": 1}
    bare = {"imitation": None, "staggered_starts": False, "validation": validation}
    reference = {"engine": "pymunk", "worlds": worlds, "options": longer}
    return {
        "batched": {**bare, "steps": UPDATES * update},
        "pymunk": {**bare, **reference, "steps": update},
    }


@contextmanager
def trained(path: Path, **changes: object) -> Iterator[tuple[Path, float, int]]:
    """Train in a separate process; yield its folder, seconds and peak memory [bytes]."""
    with tempfile.TemporaryDirectory() as folder:
        file, out = Path(folder, "run.yaml"), Path(folder, "run")
        run = load_training(path).model_dump(mode="json") | changes
        file.write_text(json.dumps(run), encoding="utf-8")  # JSON is YAML
        command = [sys.executable, "-P", "-m", "hazbot_gym", "train", "--config", str(file)]
        start = time.perf_counter()
        process = os.posix_spawn(
            sys.executable,
            [*command, "--out", str(out)],
            os.environ,
            file_actions=[(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)],
        )
        _, status, usage = os.wait4(process, 0)
        seconds = time.perf_counter() - start
        if os.waitstatus_to_exitcode(status) == 2:
            raise InvalidInput(f"training: {path.name} cannot be trained, as the line before says")
        if status != 0:
            raise RuntimeError(f"{' '.join(command)} ended with {status}")
        yield out, seconds, usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
