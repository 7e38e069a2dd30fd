"""Replay recording: episodes chosen by the reference policy's results, run with every policy.

A study records them as its last step, since the choice needs all rows. Equal seeds give equal
episodes; a drive that does not reproduce its recorded metrics is marked.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from rich.console import Console

from hazbot_gym.config import Config
from hazbot_gym.core.geometry import nearest_on_segment, path_length, sample_path
from hazbot_gym.core.sensor_ring import half_cone_of, sensors_of
from hazbot_gym.core.state import Floats, Place
from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.encounters import Row
from hazbot_gym.evaluation.episode import Episode, X, Y
from hazbot_gym.evaluation.metrics import measure
from hazbot_gym.evaluation.open_loop import Plan
from hazbot_gym.evaluation.rollout import make_env, resolve, run_episode
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies.base import NO_CODE, Permissions, Policy
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.study import store
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.headline import headline_sets
from hazbot_gym.study.replay_policies import Heard, Listener, SideBySide
from hazbot_gym.study.replay_records import Drive, Replay, Replays, Sonar, rows_of
from hazbot_gym.task.leak import leak_point
from hazbot_gym.task.observation import layout_in
from hazbot_gym.task.outcome import CONTACT_PERSON, CONTACT_WALL, OUTCOME_NAMES
from hazbot_gym.task.scenario import ScenarioSampler
from hazbot_gym.utils.json_object import JsonObject

if TYPE_CHECKING:
    import pandas as pd

TOLERANCE = 1e-6  # tolerance of reproduced metrics, as between the engines
STEP_M = 0.1  # spacing of path points
MOST_NAMES = 3  # policies named beside an episode


class Choice(NamedTuple):
    """Selected episodes of a set, by number, with reasons.

    Attributes:
        scenarios: The set.
        episodes: Reason for each episode, by number.
        best: The oracle's row of a single episode; None without an oracle.
    """

    scenarios: ScenarioSet
    episodes: dict[int, str]
    best: JsonObject | None = None


def choices(study: StudyConfig, rows: pd.DataFrame, best: pd.DataFrame | None) -> list[Choice]:
    """Return the selected episodes of a study.

    Args:
        study: The study.
        rows: Rows of all its episodes.
        best: Rows of the oracle, if the study has one.
    """
    first = rows[rows["training_seed"] == 0]
    _, headline = headline_sets(study)
    found = []
    for scenarios in study.all_sets:
        mine = first[first["scenario_set"] == scenarios.name]
        chosen = choose(mine[mine["policy"] == study.reference_policy])
        if scenarios.name in headline:
            for episode, whose in choose_worst(mine, study.shown_names).items():
                chosen[episode] = f"{chosen[episode]}, {whose}" if episode in chosen else whose
        found.append(Choice(scenarios, chosen))
    return [*found, *_beside_best(study, first, best)]


def choose(rows: pd.DataFrame) -> dict[int, str]:
    """Return at most three episodes of one policy in one set, with reasons.

    ``median`` has the median return, ``closest`` the least clearance, ``slowest`` the largest time
    ratio; one episode can be several of these. Without people there is no ``closest``.
    """
    by_return = rows.sort_values(["return", "episode"])
    met, timed = rows[np.isfinite(rows["clearance_min_m"])], rows[rows["time_ratio"].notna()]
    found = {
        "median": by_return.iloc[[(len(rows) - 1) // 2]],
        "closest": met.nsmallest(1, "clearance_min_m"),
        "slowest": timed.nlargest(1, "time_ratio"),
    }
    reasons: dict[int, list[str]] = {}
    for why, row in found.items():
        for episode in row["episode"]:
            reasons.setdefault(int(episode), []).append(why)
    return {episode: " and ".join(whys) for episode, whys in reasons.items()}


def choose_worst(rows: pd.DataFrame, policies: Sequence[str]) -> dict[int, str]:
    """Return the episodes with the least return of some policies in one set, and the policy."""
    whose: dict[int, list[str]] = {}
    for policy in policies:
        mine = rows[rows["policy"] == policy]
        whose.setdefault(int(mine["episode"].loc[mine["return"].idxmin()]), []).append(policy)
    named = {
        episode: ", ".join(names) if len(names) <= MOST_NAMES else f"{len(names)} policies"
        for episode, names in whose.items()
    }
    return {episode: f"worst of {names}" for episode, names in named.items()}


def _beside_best(
    study: StudyConfig, rows: pd.DataFrame, best: pd.DataFrame | None
) -> Iterator[Choice]:
    """Yield for each set with oracle drives the episode of the reference's median regret."""
    if best is None:
        return
    mine = rows[rows["policy"] == study.reference_policy][["scenario_set", "episode", "return"]]
    both = best.merge(mine, on=["scenario_set", "episode"], suffixes=("_best", ""))
    both = both.assign(regret=both["bound"] - both["return"]).sort_values(["regret", "episode"])
    for scenarios in study.all_sets:
        ordered = both[both["scenario_set"] == scenarios.name]
        if len(ordered):
            row = ordered.iloc[(len(ordered) - 1) // 2].to_dict()
            yield Choice(scenarios, {int(row["episode"]): "median regret"}, row)


def record(
    study: StudyConfig,
    path: Path,
    rows: pd.DataFrame,
    best: pd.DataFrame | None,
    specs: Mapping[str, str],
    *,
    stamp: str,
    threads: int,
    console: Console,
    allowed: Permissions = NO_CODE,
) -> None:
    """Record the replays of a study, unless they exist already.

    Args:
        study: The study.
        path: Path of the file.
        rows: Rows of all episodes.
        best: Rows of the oracle, if the study has one.
        specs: Spec of each policy, by name; the first seed of a learner.
        stamp: Stamp of all inputs of the drives.
        threads: Number of threads of the batched engine.
        console: Output for warnings about policies that are not reproducible.
        allowed: Permissions of the policies.
    """
    chosen = choices(study, rows, best)
    drives = sum((len(each.episodes)) * len(study.shown_names) + bool(each.best) for each in chosen)
    if not isinstance(store.read_rows(path, rows=drives, stamp=stamp), store.Missing):
        return
    found = [
        (each, replay(study, each, rows, specs, threads=threads, allowed=allowed))
        for each in chosen
    ]
    for name in _unsteady(found):
        console.print(
            f"Replays of {name!r} are other drives than the recorded ones: it does not repeat "
            "itself on the same scenario",
            markup=False,
        )
    store.write_rows(path, list(rows_of(replays_of(found))), stamp)


def _unsteady(found: Sequence[tuple[Choice, list[Replay]]]) -> list[str]:
    """Return the policies with drives that differ from the recorded episodes."""
    runs = [replay.runs for _, some in found for replay in some]
    return sorted({name for each in runs for name in each if not each[name].is_recorded})


def replay(
    study: StudyConfig,
    choice: Choice,
    rows: pd.DataFrame,
    specs: Mapping[str, str],
    *,
    threads: int = 1,
    allowed: Permissions = NO_CODE,
) -> list[Replay]:
    """Run the selected episodes of a set with all shown policies (first seed of a learner).

    Args:
        study: The study.
        choice: The episodes.
        rows: The recorded rows.
        specs: Spec of each policy, by name.
        threads: Number of threads of the batched engine.
        allowed: Permissions of the policies.
    """
    scenarios = choice.scenarios
    wanted = rows[(rows["training_seed"] == 0) & (rows["scenario_set"] == scenarios.name)]
    wanted = wanted[wanted["episode"].isin(choice.episodes)]
    recorded = {(row["policy"], row["episode"]): row for row in wanted.to_dict("records")}
    pairs = [(policy, number) for policy in study.shown_names for number in choice.episodes]
    policies = [make_policy(specs[name], **allowed._asdict()) for name in study.shown_names]
    lead = [recorded[study.reference_policy, number] for number in choice.episodes]
    runs: dict[int, dict[str, Drive]] = {number: {} for number in choice.episodes}
    again = _run(study, scenarios, policies, [int(row["seed"]) for row in lead], threads)
    config, _ = resolve(scenarios)
    source = ScenarioSampler(config)
    drawn = [source.draw(int(row["scenario_key"])) for row in lead]
    places = [scenario.place for scenario in drawn]
    walls = {
        number: np.array(place.walls) for number, place in zip(choice.episodes, places, strict=True)
    }
    for (policy, number), (episode, labels, ranges_m) in zip(pairs, again, strict=True):
        before = recorded[policy, number]
        if any(before[name] != value for name, value in labels.items()):
            raise RuntimeError(f"episode {number} of {scenarios.name!r} is another scenario now")
        is_recorded = gives_again(measure(episode, study.ssm), before)
        runs[number][policy] = drive_of(episode, ranges_m, walls[number], is_recorded=is_recorded)
    best = None
    if choice.best:
        best = _best_drive(choice.best, scenarios, next(iter(walls.values())))
    sonar = sonar_of(config)
    return [
        Replay(
            number,
            why,
            walls[number],
            path_points(each.place),
            sonar,
            leak_point(each.place, each.gas),
            runs[number],
            best,
        )
        for (number, why), each in zip(choice.episodes.items(), drawn, strict=True)
    ]


def drive_of(
    episode: Episode, ranges_m: Floats, walls: Floats, *, is_recorded: bool = True
) -> Drive:
    """Return the visible part of an episode.

    Args:
        episode: the episode.
        ranges_m: (T, sensors) readings of its sonar.
        walls: (W, 4) ends of the walls [m].
        is_recorded: whether it reproduces the recorded metrics.
    """
    steps_m = np.hypot(*np.diff(episode.pose[:, :2], axis=0).T)
    return Drive(
        time_s=episode.time_s,
        pose=episode.pose,
        speed_mps=episode.speed_mps,
        distance_m=np.append(0.0, np.cumsum(steps_m)),
        earned=np.append(0.0, np.cumsum(episode.rewards)),
        ranges_m=ranges_m,
        reading=episode.gas["smell"]["reading"],
        alarm=episode.gas["smell"]["alarm"].astype(float),
        people=episode.people,
        contact=contact_of(episode, walls),
        outcome=episode.outcome,
        contact_caused_by=episode.contact_caused_by,
        is_recorded=is_recorded,
    )


def contact_of(episode: Episode, walls: Floats) -> Floats:
    """Return the point (2,) on the robot's rim where it touched, (0,) without a contact [m].

    It is on the way to the nearest person or wall at the end of the episode.
    """
    center = episode.pose[-1, :2]
    if episode.outcome == OUTCOME_NAMES[CONTACT_PERSON]:
        at = episode.people[-1][:, [X, Y]]
    elif episode.outcome == OUTCOME_NAMES[CONTACT_WALL]:
        at = np.array([nearest_on_segment(*center, *wall) for wall in walls])
    else:
        return np.empty(0)
    aside = at - center
    distance = np.hypot(*aside.T)
    nearest = int(np.nanargmin(distance))
    point: Floats = center + episode.robot_radius_m * aside[nearest] / distance[nearest]
    return point


def sonar_of(config: Config) -> Sonar:
    """Return the geometry of an environment's sonar."""
    common, ring = config.sensors.ultrasonic, sensors_of(config.sensors.ring)
    return Sonar(
        mount_m=common.mount_radius_m,
        range_m=common.range_m,
        axes_rad=np.array([sensor.angle_rad for sensor in ring]),
        half_cones_rad=np.array([half_cone_of(sensor, common.half_cone_rad) for sensor in ring]),
    )


def replays_of(found: Sequence[tuple[Choice, list[Replay]]]) -> Replays:
    """Return the replays of all choices, by set."""
    return Replays(
        {choice.scenarios.name: some for choice, some in found if choice.best is None},
        {choice.scenarios.name: some[0] for choice, some in found if choice.best is not None},
    )


def gives_again(now: Row, recorded: JsonObject) -> bool:
    """Return True if an episode reproduces its recorded metrics."""
    return all(
        value == recorded[name]
        if isinstance(value, str)
        else np.isclose(value, recorded[name], rtol=TOLERANCE, atol=TOLERANCE, equal_nan=True)
        for name, value in now.items()
    )


def path_points(place: Place) -> Floats:
    """Return points (n, 2) along a place's path [m], its end included."""
    length = path_length(place.path.view(np.recarray))
    return sample_path(place.path, np.linspace(0.0, length, int(length / STEP_M) + 2))[:, :2]


def _best_drive(best: JsonObject, scenarios: ScenarioSet, walls: Floats) -> Drive:
    """Return the oracle's drive, from its row."""
    config, limit = resolve(scenarios)
    listener = Listener(Plan(np.asarray(best["actions"], float)), layout_in(config))
    runs = batch_rollout.run_episodes(config, listener, [int(best["seed"])], limit=limit, threads=1)
    ((episode, _, ranges_m),) = listener.heard(runs)
    return drive_of(episode, ranges_m, walls)


def _run(
    study: StudyConfig,
    scenarios: ScenarioSet,
    policies: list[Policy],
    seeds: list[int],
    threads: int,
) -> Iterator[Heard]:
    """Run every policy over some seeds, one policy after the other."""
    config, limit = resolve(scenarios)
    layout = layout_in(config)
    if study.engine == "pymunk":
        env = make_env(scenarios)
        for policy in policies:
            listener = Listener(policy, layout)
            yield from listener.heard(run_episode(env, listener, seed) for seed in seeds)
        return
    if config.action_type == "discrete":  # discrete and continuous actions do not mix in one batch
        teams = [(policy, 1) for policy in policies]
    else:
        at_once = max(batch_rollout.most_worlds(limit) // len(seeds), 1)
        parts = [policies[i : i + at_once] for i in range(0, len(policies), at_once)]
        teams = [(SideBySide(part), len(part)) for part in parts]
    for team, size in teams:
        listener = Listener(team, layout)
        runs = batch_rollout.run_episodes(
            config, listener, seeds * size, limit=limit, threads=threads
        )
        yield from listener.heard(runs)
