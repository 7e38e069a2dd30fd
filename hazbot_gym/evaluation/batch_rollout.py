"""Parallel rollouts of one policy on the batched engine.

Equal seeds give the same episodes as ``rollout.run_episode`` on the pymunk engine. All worlds start
together; a world whose episode has ended is frozen until all episodes of the batch have ended.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice

import gymnasium
import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.state import GAS, PRESENT, ROBOT_RADIUS_M, Floats, Ints
from hazbot_gym.envs.arguments import Info
from hazbot_gym.envs.vector import CorridorVectorEnv, State
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.actions import levels_of
from hazbot_gym.evaluation.driver import check_made_for, driver_of
from hazbot_gym.evaluation.encounters import Row
from hazbot_gym.evaluation.episode import (
    ENDING,
    PERSON_COLUMNS,
    Episode,
    ending,
    labels_of,
    rise_s_of,
    stack_people,
)
from hazbot_gym.evaluation.without_robot import walked_alone
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.own_policy import OwnPolicy
from hazbot_gym.task.observation import observing
from hazbot_gym.task.reward import terms_of

MOST_WORLDS = 512  # side by side; more are no faster, and their record would take more memory
LONG = 2000  # decisions; in longer episodes fewer worlds, for the same memory
ONE_AT_A_TIME = (
    "two observations are stacked here, with engine pymunk it is asked about one at a time"
)
ROBOT_COLUMNS = ("x", "y", "theta", "v", "command", "x_e", "y_e", "theta_e")


def run_episodes(
    config: Config, policy: Policy, seeds: Sequence[int], *, limit: int, threads: int
) -> Iterator[tuple[Episode, Row]]:
    """Run an episode for each seed; yield records and labels in the order of the seeds.

    Args:
        config: of the environment.
        policy: acts on stacked observations.
        seeds: of the resets.
        limit: number of decisions after which an episode is cut off.
        threads: number of threads; results do not depend on it.
    """
    rounds = -(-len(seeds) // most_worlds(limit))
    size = -(-len(seeds) // rounds)
    driver = driver_of(policy, config)
    worlds = CorridorVectorEnv(size, config, threads=threads, autoreset_mode="Disabled")
    for first in range(0, len(seeds), size):
        chosen = list(seeds[first : first + size])
        spare = [chosen[0]] * (size - len(chosen))
        yield from islice(_run_round(worlds, driver, chosen + spare, limit), len(chosen))
    worlds.close()


def most_worlds(limit: int) -> int:
    """Return the largest number of worlds side by side, for a horizon in decisions."""
    return max(MOST_WORLDS * LONG // max(limit, LONG), 1)


def try_out(config: Config, policies: Mapping[str, Policy]) -> None:
    """Make an environment, query each policy with two blank observations, and take a step.

    Raises:
        InvalidInput: the environment cannot be made, or a policy cannot act on these observations
            or on stacked ones.
    """
    worlds = CorridorVectorEnv(2, config)
    assert worlds.observation_space.shape is not None
    for name, policy in policies.items():
        check_made_for(policy, config, name)
        with observing(config):
            _try_policy(policy, name, np.zeros(worlds.observation_space.shape, np.float32))
    worlds.reset(seed=0)
    worlds.step(np.zeros_like(worlds.action_space.sample()))
    worlds.free_times_s()
    worlds.source.draw(0)


def _try_policy(policy: Policy, name: str, blank: npt.NDArray[np.float32]) -> None:
    try:
        actions, _ = policy.predict(blank, episode_start=np.ones(2, np.bool_), deterministic=True)
    except InvalidInput as error:
        if not isinstance(policy, OwnPolicy):
            raise
        raise InvalidInput(f"{error}; {ONE_AT_A_TIME}") from error
    except (TypeError, ValueError, IndexError) as error:
        raise InvalidInput(_needs_one_at_a_time(name, f"fails with {error}")) from error
    if np.shape(actions) not in ((2, 1), (2,)):
        raise InvalidInput(_needs_one_at_a_time(name, f"answers in shape {np.shape(actions)}"))


def _needs_one_at_a_time(name: str, what: str) -> str:
    return f"policy: {name!r} {what}, allowed is (2, 1); {ONE_AT_A_TIME}"


def _run_round(
    worlds: CorridorVectorEnv, policy: Policy, seeds: list[int], limit: int
) -> Iterator[tuple[Episode, Row]]:
    """Run one episode in each world."""
    observations, start = worlds.reset(seed=seeds)
    keys = start["scenario_key"].tolist()
    labels = [labels_of(worlds.episode_of(i)[1], key) for i, key in enumerate(keys)]
    log = _Log(worlds, limit)
    state, is_start = None, np.ones(worlds.num_envs, np.bool_)
    while log.live.any():
        actions, state = policy.predict(
            observations, state=state, episode_start=is_start, deterministic=True
        )
        step = worlds.step(_playable(worlds, actions), mask=log.live)
        observations = step[0]
        log.note(worlds.state(), *step[1:])
        is_start = np.zeros(worlds.num_envs, np.bool_)
    yield from zip(log.episodes(worlds, keys), labels, strict=True)


def _playable(
    worlds: CorridorVectorEnv, actions: npt.NDArray[np.generic]
) -> npt.NDArray[np.generic]:
    """Return a policy's actions in the format of the batched engine."""
    space = worlds.single_action_space
    if isinstance(space, gymnasium.spaces.Discrete):
        return levels_of(actions, int(space.n))
    return np.reshape(actions, (worlds.num_envs, 1))


class _Log:
    """Trajectory log of every world at every instant.

    Attributes:
        live: (N,) True while the world's episode is running.
    """

    def __init__(self, worlds: CorridorVectorEnv, limit: int) -> None:
        n = worlds.num_envs
        self.live = np.ones(n, np.bool_)
        self._steps, self._limit = np.zeros(n, np.int64), limit
        self._horizon_s = limit * worlds.config.clock.decision_s
        self._robots = np.empty((limit + 1, n, len(ROBOT_COLUMNS)))
        self._times_s = np.empty((limit + 1, n))
        self._rewards, self._costs = np.empty((limit, n)), np.empty((limit, n))
        self._terms = {name: np.empty((limit, n)) for name in terms_of(worlds.config)}
        self._gas = np.empty((limit + 1, n if worlds.config.gas else 0), GAS)
        self._people: list[tuple[Ints, Ints, Floats]] = []  # world, person, columns; by instant
        self._info: Info = {}
        self._note_state(0, worlds.state())

    def note(
        self,
        state: State,
        rewards: Floats,
        terminated: npt.NDArray[np.bool_],
        truncated: npt.NDArray[np.bool_],
        info: Info,
    ) -> None:
        """Record one decision of all live worlds, and which episodes it ended."""
        t = len(self._people) - 1
        self._rewards[t], self._costs[t], self._info = rewards, info["cost"], info
        for name, terms in self._terms.items():
            terms[t] = info["reward_terms"][name]
        self._note_state(t + 1, state)
        self._steps[self.live] += 1
        self.live &= ~(terminated | truncated) & (self._steps < self._limit)

    def _note_state(self, t: int, state: State) -> None:
        self._times_s[t] = state.time_s
        for column, name in enumerate(ROBOT_COLUMNS):
            self._robots[t, :, column] = state.robots[name]
        self._gas[t] = state.gas
        is_there = (state.people["status"] == PRESENT) & self.live[:, None]
        columns = np.stack([state.people[name][is_there] for name in PERSON_COLUMNS], axis=1)
        world, person = np.nonzero(is_there)
        self._people.append((world, person, columns))

    def episodes(self, worlds: CorridorVectorEnv, keys: Sequence[int]) -> Iterator[Episode]:
        """Yield the record of each world's episode; ``keys`` are those of the scenarios."""
        counts = [len(world) for world, _, _ in self._people]
        instants = np.repeat(np.arange(len(counts)), counts)
        world, persons, people = (np.concatenate(part) for part in zip(*self._people, strict=True))
        by_world = np.argsort(world, kind="stable")  # stays in the order of time within a world
        ends = np.searchsorted(world[by_world], np.arange(len(self.live) + 1))
        for i, (key, free_s) in enumerate(zip(keys, worlds.free_times_s(), strict=True)):
            mine = by_world[ends[i] : ends[i + 1]]
            count = int(self._steps[i]) + 1
            who, present = stack_people(instants[mine], persons[mine], people[mine], count)
            config, source = worlds.episode_of(i)
            alone = walked_alone(config, source, key, who, count)
            yield self._episode(i, config, present, alone, float(free_s))

    def _episode(
        self, i: int, config: Config, people: Floats, alone: Floats, free_s: float
    ) -> Episode:
        steps = int(self._steps[i])
        robot, done = self._robots[: steps + 1, i], slice(steps)
        return Episode(
            time_s=self._times_s[: steps + 1, i],
            pose=robot[:, 0:3],
            speed_mps=robot[:, 3],
            command_mps=robot[:, 4],
            pose_error=robot[:, 5:8],
            people=people,
            people_alone=alone,
            rewards=self._rewards[done, i],
            reward_terms={name: values[done, i] for name, values in self._terms.items()},
            costs=self._costs[done, i],
            **ending(*(self._info[name][i] for name in ENDING)),
            time_free_s=free_s,
            horizon_s=self._horizon_s,
            robot_radius_m=ROBOT_RADIUS_M,
            deceleration_mps2=config.drive.deceleration_mps2,
            nominal_mps=config.drive.nominal_speed_mps,
            sensor_rise_s=rise_s_of(config),
            gas=self._gas[: steps + 1, i : i + 1].reshape(-1),
        )
