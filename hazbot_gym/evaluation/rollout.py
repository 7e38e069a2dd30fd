"""Rollouts of one policy in one environment, recorded from the true state and measured."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping
from typing import NamedTuple, cast, get_args

import numpy as np

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.core.state import ROBOT_RADIUS_M, Floats, Ints, Records
from hazbot_gym.envs.arguments import Environment, Info
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE, full_id
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.actions import ask, playable
from hazbot_gym.evaluation.driver import driver_of
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
from hazbot_gym.evaluation.field_types import MOST_EPISODES, MOST_SEED, Engine
from hazbot_gym.evaluation.metrics import measure
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.evaluation.without_robot import walked_alone
from hazbot_gym.policies.base import NO_CODE, Permissions, Policy
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.sim.world import Snapshot
from hazbot_gym.utils import processors
from hazbot_gym.utils.whole_number import whole_number


class Shard(NamedTuple):
    """Consecutive episodes of one policy in one scenario set: the unit of work of a study."""

    policy: str
    scenarios: ScenarioSet
    first: int
    episodes: int
    seed: int
    ssm: SsmThresholds = SsmThresholds()
    engine: Engine = "batched"
    spec: str = ""  # spec of the policy, if different from its name
    training_seed: int = 0  # training seed of a learned policy
    allowed: Permissions = NO_CODE  # permissions of its policy; results do not depend on them


def evaluate(
    policy: str,
    env_id: str,
    *,
    episodes: int,
    seed: int = 0,
    overrides: Mapping[str, object] | None = None,
    engine: str = "batched",
    allow_pickle: bool = False,
) -> list[Row]:
    """Run a policy for some episodes and return one row of metrics each.

    Args:
        policy: built-in name with options (``constant:0.5``) or ``module:attribute``.
        env_id: id of a hazbot_gym environment.
        episodes: number of episodes.
        seed: root of the seeds of all episodes. Equal root, environment and named scenario give the
            same episodes as ``hazbot study``.
        overrides: config values that differ from the environment's own.
        engine: ``batched``, or ``pymunk`` for the reference.
        allow_pickle: whether a ``learned`` zip may execute its pickled code.

    Raises:
        InvalidInput: one of the arguments is not usable.
    """
    _check_names(policy, overrides)
    check_counts(episodes, seed)
    scenarios = scenario_set(env_id, overrides)
    if engine not in get_args(Engine):
        raise InvalidInput(f"engine: given {engine!r}, allowed are {', '.join(get_args(Engine))}")
    allowed = Permissions(allow_pickle=allow_pickle, allow_code=True)
    shard = Shard(
        policy, scenarios, 0, episodes, seed, engine=cast(Engine, engine), allowed=allowed
    )
    try_out(scenarios, [policy], shard.engine, allowed)
    return run_shard(shard, threads=processors.usable())


def _check_names(policy: object, overrides: object) -> None:
    if not isinstance(policy, str):
        raise InvalidInput(
            f"policy: given {policy!r}, allowed is text: name:option=value or module:attribute"
        )
    given = {} if overrides is None else overrides
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
        raise InvalidInput(f"overrides: given {overrides!r}, allowed is a mapping from names")


def check_counts(episodes: int, seed: int) -> None:
    """Raise InvalidInput for an invalid number of episodes or an invalid seed."""
    whole_number(episodes, "episodes", 1, MOST_EPISODES)
    whole_number(seed, "seed", 0, MOST_SEED)


def scenario_set(env_id: str, overrides: Mapping[str, object] | None = None) -> ScenarioSet:
    """Return an environment as a scenario set, with name and seeds as in ``hazbot study``."""
    changes, env = dict(overrides or {}), full_id(env_id)
    preset = env.rsplit("/", 1)[-1].rsplit("-v", 1)[0]
    name = str(changes.get("scenario") or preset)
    return ScenarioSet(name=name, env=env, overrides=changes)


def try_out(
    scenarios: ScenarioSet,
    policies: Iterable[str],
    engine: Engine,
    allowed: Permissions = NO_CODE,
) -> Config:
    """Query each policy in the environment of a set, and return the resolved config.

    Raises:
        InvalidInput: one of them cannot be made, or they do not fit each other.
    """
    made = {name: make_policy(name, **allowed._asdict()) for name in policies}
    if engine == "batched":
        config, _ = resolve(scenarios)
        batch_rollout.try_out(config, made)
        return config
    env = make_env(scenarios)
    config = cast(CorridorEnv, env.unwrapped).config
    observation, _ = env.reset(seed=0)
    for name, policy in made.items():
        action, _ = ask(driver_of(policy, config, name), observation)
    env.step(playable(action, env.action_space))
    return config


def run_shard(shard: Shard, threads: int = 1) -> list[Row]:
    """Run a shard of episodes and return their rows; they depend on the shard alone.

    Args:
        shard: what to run.
        threads: number of threads of the batched engine.
    """
    policy = make_policy(shard.spec or shard.policy, **shard.allowed._asdict())
    indices = range(shard.first, shard.first + shard.episodes)
    seeds = [episode_seed(shard.seed, shard.scenarios.name, index) for index in indices]
    if shard.engine == "batched":
        config, limit = resolve(shard.scenarios)
        runs = batch_rollout.run_episodes(config, policy, seeds, limit=limit, threads=threads)
    else:
        env = make_env(shard.scenarios)
        runs = (run_episode(env, policy, seed) for seed in seeds)
    return [
        {
            "policy": shard.policy,
            "training_seed": shard.training_seed,
            "scenario_set": shard.scenarios.name,
            "env": shard.scenarios.env,
            "episode": index,
            "seed": seed,
            "scenario": scenario_id(shard.scenarios.name, index),
            **labels,
            **measure(episode, shard.ssm),
        }
        for index, seed, (episode, labels) in zip(indices, seeds, runs, strict=True)
    ]


def run_episode(env: Environment, policy: Policy, seed: int) -> tuple[Episode, Row]:
    """Run one episode and return its record, and the labels of its scenario.

    Raises:
        InvalidInput: One of the arguments has another type, or the policy is made for another
            nominal speed or decision period.
    """
    if not hasattr(getattr(env, "unwrapped", None), "snapshot"):
        raise InvalidInput(f"env: given {env!r}, allowed is gymnasium.make of a hazbot_gym id")
    if isinstance(policy, type) or not isinstance(policy, Policy):
        raise InvalidInput(f"policy: given {policy!r}, allowed is an object with predict")
    whole_number(seed, "seed", 0)
    corridor = cast(CorridorEnv, env.unwrapped)
    driver = driver_of(policy, corridor.config)
    observation, start = env.reset(seed=int(seed))
    state, episode_start = None, np.array([True])
    snapshots, steps = [corridor.snapshot()], []
    done = False
    while not done:
        action, state = ask(driver, observation, state, episode_start)
        observation, reward, terminated, truncated, info = env.step(
            playable(action, env.action_space)
        )
        snapshots.append(corridor.snapshot())
        steps.append((float(reward), info))
        episode_start = np.array([False])
        done = terminated or truncated
    labels = labels_of(corridor.source, start["scenario_key"])
    return episode_of(corridor, snapshots, steps, start), {**labels}


def make_env(scenarios: ScenarioSet, render_mode: str | None = None) -> Environment:
    """Make the environment of a scenario set, on pymunk.

    Raises:
        InvalidInput: there is no such environment, or a config value is not allowed.
    """
    return CorridorEnv(resolve(scenarios)[0], render_mode=render_mode)


def resolve(scenarios: ScenarioSet) -> tuple[Config, int]:
    """Return the config of a set's environment, and its horizon in decisions.

    Raises:
        InvalidInput: as for ``make_env``.
    """
    _, preset = ENVIRONMENTS[full_id(scenarios.env).removeprefix(f"{NAMESPACE}/")]
    values = dict(scenarios.overrides)
    if "preset" in values:
        raise InvalidInput("preset: given, but env says which; give single values")
    config = make_config(values.pop("config", None), preset=preset, **values)
    return config, config.max_episode_steps


def episode_seed(root: int, name: str, index: int) -> int:
    """Return the reset seed of one episode of a scenario set, independent of all others."""
    key = (zlib.crc32(name.encode()), index)
    return int(np.random.SeedSequence(root, spawn_key=key).generate_state(1)[0])


def scenario_id(name: str, index: int) -> str:
    """Return the name of a scenario of a set, such as ``test/Crossing/017``."""
    return f"{name}/{index:03d}"


def environment_ids() -> list[str]:
    """Return the ids of this project's environments."""
    return [f"{NAMESPACE}/{name}" for name in ENVIRONMENTS]


def episode_of(
    corridor: CorridorEnv,
    snapshots: list[Snapshot],
    steps: list[tuple[float, Info]],
    start: Info,
    *,
    is_edited: bool = False,
) -> Episode:
    """Return the record of an episode.

    Args:
        corridor: The environment.
        snapshots: The T + 1 instants.
        steps: Reward and info of the T decisions.
        start: Info of the reset.
        is_edited: Whether people were changed from outside; where they would have walked without
            the robot is then unknown.
    """
    config = corridor.episode_config
    last = steps[-1][1]
    infos = [info for _, info in steps]
    who, people = _people([s.people for s in snapshots], [s.persons for s in snapshots])
    source, key = corridor.source, start["scenario_key"]

    def column(*fields: str) -> Floats:
        return np.array([[getattr(s, field) for field in fields] for s in snapshots], dtype=float)

    alone = np.full((*people.shape[:2], 2), np.nan)
    if not is_edited:
        alone = walked_alone(config, source, key, who, len(snapshots))

    return Episode(
        time_s=column("time_s")[:, 0],
        pose=column("x", "y", "theta"),
        speed_mps=column("speed_mps")[:, 0],
        command_mps=column("command_mps")[:, 0],
        pose_error=column("x_e", "y_e", "theta_e"),
        people=people,
        people_alone=alone,
        rewards=np.array([reward for reward, _ in steps]),
        reward_terms={
            name: np.array([info["reward_terms"][name] for info in infos])
            for name in last["reward_terms"]
        },
        costs=np.array([info["cost"] for info in infos], dtype=float),
        **ending(*(last[name] for name in ENDING)),
        time_free_s=float(start["time_free_s"]),
        horizon_s=config.max_episode_steps * config.clock.decision_s,
        robot_radius_m=ROBOT_RADIUS_M,
        deceleration_mps2=config.drive.deceleration_mps2,
        nominal_mps=config.drive.nominal_speed_mps,
        sensor_rise_s=rise_s_of(config),
        gas=np.concatenate([s.gas for s in snapshots]),
    )


def _people(present: list[Records], persons: list[Ints]) -> tuple[Ints, Floats]:
    """Return all people ever present, at all instants; see ``stack_people``."""
    counts = [len(people) for people in present]
    # Joined as bytes: numpy takes far longer to join records, field by field.
    together = np.frombuffer(b"".join(people.tobytes() for people in present), present[0].dtype)
    columns = np.stack([together[name] for name in PERSON_COLUMNS], axis=1)
    instants = np.repeat(np.arange(len(present)), counts)
    return stack_people(instants, np.concatenate(persons), columns, len(present))
