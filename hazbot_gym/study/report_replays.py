"""Episodes to look at: chosen by how the reference policy fared, and run again for every policy.

The same seeds make the same episodes. Each one that is run again must give the very numbers that
the study recorded; if it does not, there is no report.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Place
from hazbot_gym.errors import HazbotError
from hazbot_gym.policies.base import Actions, Observations, Policy
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.study import batch_rollout
from hazbot_gym.study.config import ScenarioSet, StudyConfig
from hazbot_gym.study.episode import Episode
from hazbot_gym.study.metrics import Row, measure
from hazbot_gym.study.plans import Plan
from hazbot_gym.study.rollout import make_env, resolve, run_episode
from hazbot_gym.task.scenario import Source

if TYPE_CHECKING:
    import pandas as pd

TOLERANCE = 1e-6  # of what an episode gives again; the engines agree as closely


class Replay(NamedTuple):
    """One scenario of a set, as every policy drove through it.

    Attributes:
        number: the episode's number in its set.
        why: what it was chosen for, such as ``median``.
        place: walls and path.
        runs: the episode of each policy.
    """

    number: int
    why: str
    place: Place
    runs: dict[str, Episode]


def choose(rows: pd.DataFrame) -> dict[int, str]:
    """Return which episodes of one policy in one set are worth a look, and why, at most three.

    ``median`` has the median return, ``closest`` the least clearance, ``slowest`` the largest time
    ratio; one episode can be several of these.
    """
    by_return = rows.sort_values(["return", "episode"])["episode"]
    found = {
        "median": by_return.iloc[(len(by_return) - 1) // 2],
        "closest": rows["episode"].loc[rows["clearance_min_m"].idxmin()],
        "slowest": rows["episode"].loc[rows["time_ratio"].idxmax()],
    }
    reasons: dict[int, list[str]] = {}
    for why, episode in found.items():
        reasons.setdefault(int(episode), []).append(why)
    return {episode: " and ".join(whys) for episode, whys in reasons.items()}


def choose_worst(rows: pd.DataFrame, policies: Sequence[str]) -> dict[int, str]:
    """Return the episodes of least return of some policies in one set, and whose they are."""
    whose: dict[int, list[str]] = {}
    for policy in policies:
        mine = rows[rows["policy"] == policy]
        whose.setdefault(int(mine["episode"].loc[mine["return"].idxmin()]), []).append(policy)
    return {episode: f"worst of {', '.join(names)}" for episode, names in whose.items()}


def replay_set(
    study: StudyConfig,
    scenarios: ScenarioSet,
    rows: pd.DataFrame,
    specs: Mapping[str, str],
    *,
    with_worst: bool = False,
) -> list[Replay]:
    """Run episodes of a set again: those that ``choose`` finds and, if asked, everybody's worst.

    The other arguments are those of ``replay``.
    """
    first = rows[rows["training_seed"] == 0]
    chosen = choose(first[first["policy"] == study.reference_policy])
    if with_worst:
        for episode, whose in choose_worst(first, study.shown_names).items():
            chosen[episode] = f"{chosen[episode]}, {whose}" if episode in chosen else whose
    return replay(study, scenarios, rows, specs, chosen)


def best_drive(
    study: StudyConfig,
    scenarios: ScenarioSet,
    rows: pd.DataFrame,
    specs: Mapping[str, str],
    best: pd.DataFrame,
) -> tuple[Replay, Episode]:
    """Run the episode again in which the reference's regret is the median, and its best drive.

    Args:
        study: as for ``replay``.
        scenarios: likewise.
        rows: likewise.
        specs: likewise.
        best: the yardstick's rows of that set.
    """
    first = rows[(rows["training_seed"] == 0) & (rows["policy"] == study.reference_policy)]
    merged = best.merge(first[["episode", "return"]], on="episode", suffixes=("_best", ""))
    ordered = merged.assign(regret=merged["bound"] - merged["return"]).sort_values(
        ["regret", "episode"]
    )
    chosen = ordered.iloc[(len(ordered) - 1) // 2]
    (found,) = replay(study, scenarios, rows, specs, {int(chosen["episode"]): "median regret"})
    plan = Plan(np.asarray(chosen["actions"], float))
    config, limit = resolve(scenarios)
    runs = batch_rollout.run_episodes(config, plan, [int(chosen["seed"])], limit=limit, threads=1)
    return found, next(iter(runs))[0]


def replay(
    study: StudyConfig,
    scenarios: ScenarioSet,
    rows: pd.DataFrame,
    specs: Mapping[str, str],
    chosen: Mapping[int, str],
) -> list[Replay]:
    """Run some episodes of a set again, with all who are shown; of a learner with its first seed.

    Args:
        study: what was run.
        scenarios: the set.
        rows: what was recorded in that set.
        specs: what each policy is made of, by name.
        chosen: numbers of the episodes, and why they are worth a look.

    Raises:
        HazbotError: an episode does not give its recorded numbers again.
    """
    rows = rows[rows["training_seed"] == 0]
    recorded = {
        (row["policy"], row["episode"]): row
        for row in rows[rows["episode"].isin(chosen)].to_dict("records")
    }
    pairs = [(policy, index) for policy in study.shown_names for index in chosen]
    policies = [make_policy(specs[name]) for name in study.shown_names]
    seeds = [int(recorded[study.reference_policy, index]["seed"]) for index in chosen]
    runs: dict[int, dict[str, Episode]] = {index: {} for index in chosen}
    for (policy, index), (episode, labels) in zip(
        pairs, _run(study, scenarios, policies, seeds), strict=True
    ):
        check({**labels, **measure(episode, study.ssm)}, recorded[policy, index])
        runs[index][policy] = episode
    source = Source(resolve(scenarios)[0])
    keys = [int(recorded[study.reference_policy, index]["scenario_key"]) for index in chosen]
    return [
        Replay(index, why, source.draw(key).place, runs[index])
        for (index, why), key in zip(chosen.items(), keys, strict=True)
    ]


def check(again: Row, recorded: Mapping[str, Any]) -> None:
    """Compare what an episode gives now with what it gave in the study.

    Raises:
        HazbotError: they differ; the line names the first difference.
    """
    for name, value in again.items():
        before = recorded.get(name)
        same = (
            before == value
            if isinstance(value, str)
            else np.isclose(value, before, rtol=TOLERANCE, atol=TOLERANCE, equal_nan=True)
        )
        if not same:
            raise HazbotError(
                f"report: episode {recorded['episode']} of {recorded['scenario_set']!r} with "
                f"{recorded['policy']!r} now gives {name} = {value}, the study recorded {before}; "
                "code or data have changed since, run the study again"
            )


def _run(
    study: StudyConfig, scenarios: ScenarioSet, policies: list[Policy], seeds: list[int]
) -> Iterator[tuple[Episode, Row]]:
    """Run every policy over some seeds, one policy after the other."""
    if study.engine == "pymunk":
        env = make_env(scenarios)
        return (run_episode(env, policy, seed) for policy in policies for seed in seeds)
    config, limit = resolve(scenarios)
    if config.action_type == "discrete":  # levels and speeds do not mix in one batch
        teams = [(policy, seeds) for policy in policies]
    else:
        teams = [(_SideBySide(policies, len(seeds)), seeds * len(policies))]
    return (
        run
        for team, its_seeds in teams
        for run in batch_rollout.run_episodes(config, team, its_seeds, limit=limit, threads=1)
    )


class _SideBySide:
    """Policies that each drive some of the worlds of one batch, which is quicker than in turns."""

    def __init__(self, policies: Sequence[Policy], worlds_each: int) -> None:
        self._policies, self._worlds_each = policies, worlds_each

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, list[Any]]:
        """Return the actions of all, and each policy's own inner state."""
        actions, states = [], []
        for i, policy in enumerate(self._policies):
            mine = slice(i * self._worlds_each, (i + 1) * self._worlds_each)
            action, inner = policy.predict(
                observation[mine],
                state=None if state is None else state[i],
                episode_start=None if episode_start is None else episode_start[mine],
                deterministic=deterministic,
            )
            actions.append(np.reshape(action, (self._worlds_each, 1)))
            states.append(inner)
        return np.concatenate(actions), states
