"""Viewer of a policy in a window or on file, for ``hazbot watch``."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from contextlib import closing
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, cast

import gymnasium

from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.envs.arguments import Environment, Info
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.frame import Frame
from hazbot_gym.envs.viewer import Viewer
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.encounters import Row
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.evaluation.metrics import measure
from hazbot_gym.evaluation.rollout import (
    check_counts,
    episode_seed,
    make_env,
    run_episode,
    scenario_set,
)
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.utils.files import check_writable, write_atomically
from hazbot_gym.utils.terminal import FittedTable
from hazbot_gym.viewer.keyboard import KEYBOARD, Keyboard
from hazbot_gym.viewer.sinks import (
    MOST_PER_S,
    PICTURE,
    VIDEOS,
    PictureSink,
    Sink,
    Stopped,
    VideoSink,
    WindowSink,
)
from hazbot_gym.viewer.tiles import FrameRecorder, Tiles
from hazbot_gym.viewer.video import Image

SMOOTH = ".mp4"  # has pictures between decisions; a gif would be too large
SLOWEST, FASTEST = 0.01, 100.0  # playback speed relative to real time
MOST_POLICIES = 4  # side by side
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
        beside: Further policies, shown side by side with the first in the same scenarios.
    """

    policy: str
    env_id: str
    episodes: int = 1
    seed: int = 0
    overrides: Mapping[str, object] = MappingProxyType({})
    speed: float = 1.0
    allow_pickle: bool = False
    beside: tuple[str, ...] = ()

    @property
    def policies(self) -> tuple[str, ...]:
        """All policies shown."""
        return (self.policy, *self.beside)


class Watched(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Environment wrapper that feeds a sink with some pictures for each decision."""

    def __init__(self, env: Environment, sink: Sink, pictures: int) -> None:
        super().__init__(env)
        self._sink, self._pictures = sink, pictures

    def reset(self, **options: Any) -> tuple[Any, Info]:
        """Reset, and show the instant."""
        observation, info = self.env.reset(**options)
        self._sink.see(self._paint, info["time_s"], is_last=False)
        return observation, info

    def step(self, action: object) -> tuple[object, Any, bool, bool, Info]:
        """Step, and show the instant."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        is_last = terminated or truncated
        for k in range(1, self._pictures):
            paint = partial(self._viewer.picture_between, k / self._pictures)
            self._sink.see(paint, info["time_s"], is_last=False, is_between=True)
        self._sink.see(self._paint, info["time_s"], is_last=is_last)
        return observation, reward, terminated, truncated, info

    def _paint(self) -> Image:
        return cast(Image, self.env.render())

    @property
    def _viewer(self) -> Viewer:
        return cast(CorridorEnv, self.env.unwrapped).viewer


def watch_live(show: Show) -> list[Row]:
    """Show a policy in a window until its episodes end or the user stops it.

    Returns: One row of metrics for each completed episode.

    Raises:
        InvalidInput: an argument is not usable, or there is no display.
    """
    env, rate = _make(show)
    pictures, keyboard = _smooth(rate), Keyboard() if show.policy == KEYBOARD else None
    title = f"{', '.join(show.policies)} in {show.env_id}"
    with closing(WindowSink(title, rate * pictures, keyboard)) as sink:
        return _play(show, env, sink, pictures, keyboard)


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
        pictures = _smooth(rate) if path.suffix == SMOOTH else 1
        if path.suffix == PICTURE:
            sink = PictureSink(beside, at_s)
        else:
            sink = VideoSink(beside, path.suffix, rate * pictures)
        with closing(sink):
            rows.extend(_play(show, env, sink, pictures))
        sink.check()

    write_atomically(path, write)
    return rows


def table(rows: list[Row]) -> FittedTable:
    """Return a table with one row per episode."""
    result = FittedTable(box=None, pad_edge=False)
    columns = {**COLUMNS, **GAS_COLUMNS} if any("leak" in row for row in rows) else COLUMNS
    if len({row["policy"] for row in rows}) > 1:
        columns = {"policy": "s", **columns}
    for name in columns:
        result.add_column(name, justify="left" if name in ("policy", "outcome") else "right")
    for row in rows:
        result.add_row(*(format(row[name], form) for name, form in columns.items()))
    return result


def _smooth(decisions_per_s: float) -> int:
    """Return the number of pictures for each decision, for the rate of a film."""
    return max(int(MOST_PER_S // decisions_per_s), 1)


def _make(show: Show) -> tuple[Environment, float]:
    """Return the environment, and its decisions a second of playback."""
    check_counts(show.episodes, show.seed)
    policies = show.policies
    if len(set(policies)) < len(policies) or len(policies) > MOST_POLICIES:
        raise InvalidInput(
            f"policy: given {', '.join(policies)}, allowed are 1 to {MOST_POLICIES} different ones"
        )
    if KEYBOARD in show.beside or (KEYBOARD in policies and show.beside):
        raise InvalidInput(f"policy: given {KEYBOARD} beside others, allowed is {KEYBOARD} alone")
    if not SLOWEST <= show.speed <= FASTEST:
        raise InvalidInput(f"speed: given {show.speed}, allowed is {SLOWEST} to {FASTEST}")
    env = make_env(scenario_set(show.env_id, show.overrides), "rgb_array")
    corridor = cast(CorridorEnv, env.unwrapped)
    place = scenario_set(show.env_id, show.overrides).name
    corridor.viewer.caption = f"{show.policy} in {place}"
    return env, show.speed / corridor.config.clock.decision_s


def _play(
    show: Show, env: Environment, sink: Sink, pictures: int, keyboard: Keyboard | None = None
) -> list[Row]:
    """Show episodes until there are enough, or the user stops; return a row of each drive."""
    made = {
        name: keyboard or make_policy(name, allow_pickle=show.allow_pickle)
        for name in show.policies
    }
    name = scenario_set(show.env_id, show.overrides).name
    rows: list[Row] = []
    for index in itertools.count():
        seed = episode_seed(show.seed, name, index)
        try:
            if len(made) == 1:
                episode, _ = run_episode(Watched(env, sink, pictures), made[show.policy], seed)
                episodes = {show.policy: episode}
            else:
                episodes = _together(env, made, seed, sink, pictures)
        except Stopped as stopped:
            if stopped.for_good:
                return rows
            continue
        rows += [
            {"policy": policy, "seed": seed, **measure(episode, SsmThresholds())}
            for policy, episode in episodes.items()
        ]
        if len(rows) == len(made) * show.episodes:
            return rows
    raise AssertionError("there are always more seeds")


def _together(
    env: Environment, policies: Mapping[str, Policy], seed: int, sink: Sink, pictures: int
) -> dict[str, Episode]:
    """Drive an episode with each policy, then show the drives side by side."""
    episodes, drives = dict[str, Episode](), dict[str, list[Frame]]()
    for name, policy in policies.items():
        recorder = FrameRecorder(env)
        episodes[name], _ = run_episode(recorder, policy, seed)
        drives[name] = recorder.frames
    tiles = Tiles(drives)
    times_s = max((each.time_s for each in episodes.values()), key=len)
    for k in range((tiles.instants - 1) * pictures + 1):
        instant, rest = divmod(k, pictures)
        sink.see(
            partial(tiles.picture, k / pictures),
            float(times_s[instant]),
            is_last=instant == tiles.instants - 1,
            is_between=rest > 0,
        )
    return episodes


def _check_file(show: Show, path: Path, at_s: float | None, is_replacing: bool) -> None:
    given, endings = f"given {str(path)!r}", (*VIDEOS, PICTURE)
    if show.policy == KEYBOARD:
        raise InvalidInput(f"save: {given}, but the policy {KEYBOARD} needs the window")
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
