"""Viewer of a policy in a window or on file, for ``hazbot watch``."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, cast

import gymnasium

from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.envs.arguments import Environment, Info
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.encounters import Row
from hazbot_gym.evaluation.metrics import measure
from hazbot_gym.evaluation.rollout import (
    check_counts,
    episode_seed,
    make_env,
    run_episode,
    scenario_set,
)
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.utils.files import check_writable, write_atomically
from hazbot_gym.utils.terminal import FittedTable
from hazbot_gym.viewer.sinks import (
    PICTURE,
    VIDEOS,
    PictureSink,
    Sink,
    Stopped,
    VideoSink,
    WindowSink,
)
from hazbot_gym.viewer.video import Image

SLOWEST, FASTEST = 0.01, 100.0  # playback speed relative to real time
# Metrics printed per episode, and their format.
COLUMNS = {
    "seed": "d",
    "outcome": "s",
    "time_s": ".1f",
    "return": "z.1f",
    "delay_s": ".1f",
    "personal_m": ".1f",
    "discomfort_s": ".2f",
}
GAS_COLUMNS = {"leak": "d", "leak_found": ".0f", "false_alarms": "d", "time_to_alarm_s": ".1f"}


class Show(NamedTuple):
    """Arguments of a viewing; equal arguments give the same episodes as ``hazbot eval``.

    Attributes:
        policy: Built-in name with options, or ``module:attribute``.
        env_id: Id of a hazbot_gym environment.
        episodes: Number of episodes.
        seed: Root of the seeds of all episodes.
        overrides: Config values that differ from the environment's own.
        speed: Playback speed relative to real time.
        allow_pickle: Whether a ``learned`` zip may execute its pickled code.
    """

    policy: str
    env_id: str
    episodes: int = 1
    seed: int = 0
    overrides: Mapping[str, object] = MappingProxyType({})
    speed: float = 1.0
    allow_pickle: bool = False


class Watched(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Environment wrapper that feeds a sink."""

    def __init__(self, env: Environment, sink: Sink) -> None:
        super().__init__(env)
        self._sink = sink

    def reset(self, **options: Any) -> tuple[Any, Info]:
        """Reset, and show the instant."""
        observation, info = self.env.reset(**options)
        self._sink.see(self._paint, info["time_s"], is_last=False)
        return observation, info

    def step(self, action: object) -> tuple[object, Any, bool, bool, Info]:
        """Step, and show the instant."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        is_last = terminated or truncated
        self._sink.see(self._paint, info["time_s"], is_last=is_last)
        return observation, reward, terminated, truncated, info

    def _paint(self) -> Image:
        return cast(Image, self.env.render())


def watch_live(show: Show) -> list[Row]:
    """Show a policy in a window until its episodes end or the user stops it.

    Returns: One row of metrics for each completed episode.

    Raises:
        InvalidInput: an argument is not usable, or there is no display.
    """
    env, rate = _make(show)
    with closing(WindowSink(f"{show.policy} in {show.env_id}", rate)) as sink:
        return _play(show, env, sink)


def save(
    show: Show, path: Path, *, at_s: float | None = None, is_replacing: bool = False
) -> list[Row]:
    """Save a policy's episodes as a video, or a picture; the file is complete or absent.

    Args:
        show: Policy, environment and episodes.
        path: Ends in ``.mp4``, ``.gif`` or ``.png``.
        at_s: Episode time of the picture; the end if None.
        is_replacing: Whether to replace an existing file.

    Returns:
        One row of metrics for each episode.

    Raises:
        InvalidInput: an argument is not usable.
    """
    _check_file(show, path, at_s, is_replacing)
    env, rate = _make(show)
    rows: list[Row] = []

    def write(beside: Path) -> None:
        sink: VideoSink | PictureSink
        if path.suffix == PICTURE:
            sink = PictureSink(beside, at_s)
        else:
            sink = VideoSink(beside, path.suffix, rate)
        with closing(sink):
            rows.extend(_play(show, env, sink))
        sink.check()

    write_atomically(path, write)
    return rows


def table(rows: list[Row]) -> FittedTable:
    """Return a table with one row per episode."""
    result = FittedTable(box=None, pad_edge=False)
    columns = {**COLUMNS, **GAS_COLUMNS} if any("leak" in row for row in rows) else COLUMNS
    for name in columns:
        result.add_column(name, justify="left" if name == "outcome" else "right")
    for row in rows:
        result.add_row(*(format(row[name], form) for name, form in columns.items()))
    return result


def _make(show: Show) -> tuple[Environment, float]:
    """Return the environment, and its frame rate."""
    check_counts(show.episodes, show.seed)
    if not SLOWEST <= show.speed <= FASTEST:
        raise InvalidInput(f"speed: given {show.speed}, allowed is {SLOWEST} to {FASTEST}")
    env = make_env(scenario_set(show.env_id, show.overrides), "rgb_array")
    decision_s = cast(CorridorEnv, env.unwrapped).config.clock.decision_s
    return env, show.speed / decision_s


def _play(show: Show, env: Environment, sink: Sink) -> list[Row]:
    policy, watched = make_policy(show.policy, allow_pickle=show.allow_pickle), Watched(env, sink)
    name = scenario_set(show.env_id, show.overrides).name
    rows: list[Row] = []
    for index in itertools.count():
        seed = episode_seed(show.seed, name, index)
        try:
            episode, _ = run_episode(watched, policy, seed)
        except Stopped as stopped:
            if stopped.for_good:
                return rows
            continue
        rows.append({"seed": seed, **measure(episode, SsmThresholds())})
        if len(rows) == show.episodes:
            return rows
    raise AssertionError("there are always more seeds")


def _check_file(show: Show, path: Path, at_s: float | None, is_replacing: bool) -> None:
    given, endings = f"given {str(path)!r}", (*VIDEOS, PICTURE)
    if path.suffix not in endings:
        raise InvalidInput(f"save: {given}, allowed endings are {', '.join(endings)}")
    if path.is_dir() or (path.exists() and not is_replacing):
        raise InvalidInput(f"save: {given}, which exists; give another name, or --force")
    if at_s is not None and not at_s >= 0.0:
        raise InvalidInput(f"at: given {at_s}, allowed is 0 or more")
    check_writable(path, "save")
    if path.suffix == PICTURE and show.episodes > 1:
        raise InvalidInput(f"episodes: given {show.episodes}, a picture shows 1")
    if path.suffix != PICTURE and at_s is not None:
        raise InvalidInput(f"at: given {at_s}, but only a picture ({PICTURE}) is of one time")
