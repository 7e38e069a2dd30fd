"""Benchmark cases: single environments, batches of worlds, and policies."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

import gymnasium
import numpy as np

from hazbot_gym.envs.arguments import Batch, Environment
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.errors import MissingExtra
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.policies.guard import Observations
from hazbot_gym.utils.json_object import JsonObject

CARTPOLE, CORRIDOR = "CartPole-v1", "hazbot_gym/Corridor-v1"
CARTPOLES = f"{CARTPOLE}, 1024 worlds"
WORLDS, PEOPLE = (1, 64, 1024, 8192), (0, 4, 10)
WITH = "social-force people, ultrasonic ranges, people tracker, fuzzy-PID wheel loops at 100 Hz"
SHIPPED = "ppo"  # the shipped trained policy
DRAWN = 64  # actions are drawn in advance, and reused


def batched(worlds: int, people: int) -> str:
    """Return the name of a case of the batched engine."""
    return f"batched, {worlds} worlds, {people} people"


def asking(policy: str) -> str:
    """Return the name of the case that queries a policy with a batch."""
    return f"policy {policy}, 1024 observations"


def with_people(count: int) -> JsonObject:
    """Return the config of a corridor with a fixed number of people."""
    return {"people": {"model": "social_force", "count": [count, count]}}


# Ablations on one thread: the differences give the time of each part.
ONE_THREAD = f"{batched(1024, 4)}, 1 thread"
WITH_GAS = f"{ONE_THREAD}, gas"
WITHOUT_PEOPLE = f"{batched(1024, 0)}, 1 thread"
WITHOUT_WHEELS = f"{WITHOUT_PEOPLE}, ideal wheels"
IDEAL_WHEELS = {"wheel_loop": "ideal", "wheel_noise_radps": 0.0, "heading_noise_rad": 0.0}


class Case(Protocol):
    """A benchmark case, run call by call."""

    size: int  # steps, or policy queries, per call

    def run(self, calls: int) -> None:
        """Continue from the end of the last run."""
        ...


class Stepper:
    """Steps an environment with random actions, and resets it where it ends."""

    size = 1

    def __init__(self, env: Environment, seed: int = 0) -> None:
        self.env = env
        env.action_space.seed(seed)
        self.actions = [env.action_space.sample() for _ in range(DRAWN)]
        env.reset(seed=seed)

    def run(self, calls: int) -> None:
        """Take a number of steps."""
        step, reset, actions = self.env.step, self.env.reset, self.actions
        for k in range(calls):
            _, _, terminated, truncated, _ = step(actions[k % DRAWN])
            if terminated or truncated:
                reset()


class VectorStepper:
    """Steps a vector environment with random actions; it resets its worlds itself."""

    def __init__(self, envs: Batch, seed: int = 0) -> None:
        self.envs, self.size = envs, envs.num_envs
        envs.action_space.seed(seed)
        self.actions = [envs.action_space.sample() for _ in range(DRAWN)]
        envs.reset(seed=seed)

    def run(self, calls: int) -> None:
        """Take a number of steps in every world."""
        for k in range(calls):
            self.envs.step(self.actions[k % DRAWN])


class CorridorStepper(VectorStepper):
    """Steps the batched engine, with worlds at different times of their episodes."""

    def __init__(
        self, worlds: int, people: int, *, spread: int, threads: int | None = None, **config: Any
    ) -> None:
        envs = CorridorVectorEnv(worlds, threads=threads, **with_people(people), **config)
        super().__init__(envs)
        ages = np.random.default_rng(0).integers(spread + 1, size=worlds)
        for k in range(int(ages.max())):
            envs.step(self.actions[k % DRAWN], mask=ages > k)


class Sb3Stepper:
    """Steps the adapter to Stable-Baselines3."""

    def __init__(self, worlds: int, people: int) -> None:
        from hazbot_gym.envs.sb3 import CorridorVecEnv

        self.envs, self.size = CorridorVecEnv(worlds, seed=0, **with_people(people)), worlds
        rng = np.random.default_rng(0)
        self.actions = rng.uniform(-1.0, 1.0, (DRAWN, worlds, 1)).astype(np.float32)
        self.envs.reset()

    def run(self, calls: int) -> None:
        """Take a number of steps in every world."""
        for k in range(calls):
            self.envs.step(self.actions[k % DRAWN])


class Asker:
    """Queries a policy with observations."""

    def __init__(self, policy: Policy, observations: Observations) -> None:
        self.policy, self.observations = policy, observations
        self.size = len(observations) if observations.ndim > 1 else 1

    def run(self, calls: int) -> None:
        """Query a number of times."""
        for _ in range(calls):
            self.policy.predict(self.observations)


def make_cases(spread: int) -> tuple[dict[str, Case], list[str]]:
    """Return all cases by name, CartPole-v1 first, and a note on each unavailable case.

    Args:
        spread: largest difference of episode steps between worlds of a batch.
    """
    cases: dict[str, Case] = {
        CARTPOLE: Stepper(gymnasium.make(CARTPOLE)),
        CARTPOLES: VectorStepper(
            gymnasium.make_vec(CARTPOLE, 1024, vectorization_mode="vector_entry_point")
        ),
        CORRIDOR: Stepper(gymnasium.make(CORRIDOR, **with_people(4))),
    }
    for worlds in WORLDS:
        for people in PEOPLE:
            cases[batched(worlds, people)] = CorridorStepper(worlds, people, spread=spread)
    one_thread = CorridorStepper(1024, 4, spread=spread, threads=1)
    cases[ONE_THREAD] = one_thread
    cases[WITH_GAS] = CorridorStepper(1024, 4, spread=spread, threads=1, gas={})
    cases[WITHOUT_PEOPLE] = CorridorStepper(1024, 0, spread=spread, threads=1)
    cases[WITHOUT_WHEELS] = CorridorStepper(1024, 0, spread=spread, threads=1, drive=IDEAL_WHEELS)
    cases |= dict(_policies(one_thread))
    try:
        cases["SB3 adapter, 1024 worlds, 4 people"] = Sb3Stepper(1024, 4)
    except MissingExtra as error:
        return cases, [f"SB3 adapter left out: {error}"]
    return cases, []


def _policies(worlds: CorridorStepper) -> Iterator[tuple[str, Case]]:
    """Yield the cases of the policies, with observations of the worlds."""
    observations = worlds.envs.step(worlds.actions[0])[0]
    for name in ("fuzzy_expert", SHIPPED, "constant"):
        policy = make_policy(name)
        yield f"policy {name}, 1 observation", Asker(policy, observations[0])
        yield asking(name), Asker(policy, observations)
