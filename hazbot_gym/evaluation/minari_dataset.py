"""Data sets of a policy's episodes in Minari's format, for offline learning.

Episodes are those of ``rollout.run_episode``, so on pymunk. The environment's spec and each
episode's seed are in the data set: ``MinariDataset.recover_environment`` and the recorded actions
give the same rewards to the bit. Minari's own ``DataCollector`` needs JAX; this module does not.
"""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple, SupportsFloat

import gymnasium
import numpy as np
import numpy.typing as npt

from hazbot_gym import __version__
from hazbot_gym.envs.arguments import Environment, Info
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.evaluation.rollout import (
    check_counts,
    episode_seed,
    run_episode,
    scenario_set,
    try_out,
)
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies.base import Permissions
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.policies.guard import Observations
from hazbot_gym.utils.files import check_writable
from hazbot_gym.utils.json_object import JsonObject

try:
    import h5py  # noqa: F401  (the storage's format)
    import minari
    from minari.data_collector import EpisodeBuffer
    from minari.dataset.minari_dataset import parse_dataset_id
    from minari.dataset.minari_storage import MinariStorage
except ImportError as error:
    raise MissingExtra(error.name or "minari", "datasets") from error

DATA = "data"  # subfolder with the data, as Minari expects


class Written(NamedTuple):
    """Size and mean return of a data set."""

    episodes: int
    decisions: int
    mean_return: float


def write_dataset(
    policy: str,
    env_id: str,
    out: Path,
    *,
    episodes: int,
    seed: int = 0,
    overrides: Mapping[str, object] | None = None,
    allow_pickle: bool = False,
    on_progress: Callable[[], object] = lambda: None,
) -> Written:
    """Write a policy's episodes as a Minari data set; it is complete or absent.

    Args:
        policy: Spec, as of ``evaluate``.
        env_id: Id of a hazbot_gym environment.
        out: New folder; its name is the id, such as ``crossing-expert-v0``.
        episodes: Number of episodes.
        seed: Root of the seeds; the episodes have the seeds of ``evaluate``.
        overrides: Config values that differ from the environment's own.
        allow_pickle: Whether a ``learned`` zip may execute its pickled code.
        on_progress: Called after each episode.

    Raises:
        InvalidInput: An argument is not usable, or the folder exists.
        MissingExtra: Minari is not installed.
    """
    check_counts(episodes, seed)
    _check_folder(out)
    scenarios, allowed = scenario_set(env_id, overrides), Permissions(allow_pickle, True)
    try_out(scenarios, [policy], "pymunk", allowed)
    driver, returns, decisions = make_policy(policy, **allowed._asdict()), [], 0
    with _filled(out) as folder, closing(_recoverable_env(scenarios)) as env:
        recorder, storage = _Recorder(env), _new_storage(folder / DATA, env)
        for index in range(episodes):
            start = episode_seed(seed, scenarios.name, index)
            episode, _ = run_episode(recorder, driver, start)
            storage.update_episodes([recorder.episode(index, start)])
            returns.append(float(episode.rewards.sum()))
            decisions += len(episode.rewards)
            on_progress()
        storage.update_metadata(_metadata(out.name, policy, scenarios, episodes, seed))
    return Written(episodes, decisions, float(np.mean(returns)))


class _Recorder(gymnasium.Wrapper[Observations, object, Observations, object]):
    """Environment wrapper that records the current episode."""

    def reset(
        self, *, seed: int | None = None, options: Info | None = None
    ) -> tuple[Observations, Info]:
        """Reset, and begin a record."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._seen, self._infos = [observation], [info]
        self._actions: list[npt.NDArray[np.generic]] = []
        self._steps: list[tuple[float, bool, bool]] = []
        return observation, info

    def step(self, action: object) -> tuple[Observations, SupportsFloat, bool, bool, Info]:
        """Take the action in the precision of the action space, which is that of the record."""
        taken = np.asarray(action, self.action_space.dtype)
        observation, reward, terminated, truncated, info = self.env.step(taken)
        self._seen.append(observation)
        self._infos.append(info)
        self._actions.append(taken)
        self._steps.append((float(reward), terminated, truncated))
        return observation, reward, terminated, truncated, info

    def episode(self, index: int, seed: int) -> EpisodeBuffer:
        """Return the record: T + 1 observations and infos, T actions and rewards."""
        rewards, terminations, truncations = map(list, zip(*self._steps, strict=True))
        return EpisodeBuffer(
            id=index,
            seed=seed,
            observations=np.stack(self._seen),
            actions=np.stack(self._actions),
            rewards=rewards,
            terminations=terminations,
            truncations=truncations,
            infos=_columns(self._infos),
        )


def _columns(infos: list[Info]) -> JsonObject:
    """Return nested columns of a list of infos; texts stay lists."""
    columns: JsonObject = {}
    for name, first in infos[0].items():
        values = [info[name] for info in infos]
        if isinstance(first, Mapping):
            columns[name] = _columns(values)
        else:
            columns[name] = values if isinstance(first, str) else np.array(values)
    return columns


def _recoverable_env(scenarios: ScenarioSet) -> Environment:
    """Return the environment of a scenario set with a spec, which ``gymnasium.make`` gives it."""
    return gymnasium.make(scenarios.env, disable_env_checker=True, **scenarios.overrides)


def _new_storage(folder: Path, env: Environment) -> MinariStorage:
    return MinariStorage.new(
        folder,
        observation_space=env.observation_space,
        action_space=env.action_space,
        env_spec=env.spec,
        data_format="hdf5",
    )


def _metadata(
    name: str, policy: str, scenarios: ScenarioSet, episodes: int, seed: int
) -> JsonObject:
    return {
        "dataset_id": name,
        "minari_version": minari.__version__,
        "algorithm_name": policy,
        "description": (
            f"{episodes} episodes of the policy {policy} in {scenarios.env}, root seed {seed}; "
            "written by hazbot dataset."
        ),
        "requirements": [f"hazbot-gym=={__version__}"],
    }


def _check_folder(out: Path) -> None:
    """Raise before any work if the folder cannot become a data set."""
    if os.path.lexists(out):
        raise InvalidInput(f"out: {str(out)!r} exists; give another folder")
    try:
        parse_dataset_id(out.name)
    except (TypeError, ValueError) as error:  # TypeError: no version
        raise InvalidInput(
            f"out: given {str(out)!r}, allowed is a folder with a name such as crossing-expert-v0: "
            "letters, digits, - and _, and a version at the end"
        ) from error
    check_writable(out / DATA)


@contextmanager
def _filled(out: Path) -> Iterator[Path]:
    """Context manager: a temporary folder beside ``out``, renamed to it if all goes well."""
    # Minari joins relative folders with themselves when it adds up the files' sizes.
    beside = out.absolute().with_name(f".{out.name}.{secrets.token_hex(4)}.tmp")
    beside.mkdir(parents=True)
    try:
        yield beside
        beside.rename(out)
    finally:
        shutil.rmtree(beside, ignore_errors=True)
