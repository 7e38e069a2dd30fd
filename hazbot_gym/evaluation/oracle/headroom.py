"""Benchmark headroom: the span from a constant speed to the best drive known.

A benchmark in which a one-line rule is optimal cannot tell policies apart. The span runs from the
best constant speed without contacts (0) to the best drive known of each scenario (1). Among people
who do not yield, every constant speed makes contacts; the zero is the best constant speed with a
protective stop, over both its speed and its stopping distance. The position of the best
one-parameter rule bounds the room left for other policies from below.

Parameters of rules are tuned on other scenarios of the same environment. The best drive known is
the result of an offline search (``trajectory_search.py``), or with scripted people and ideal wheels
the exact optimum (``dynamic_programming.py``); both know the future.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config, make_config
from hazbot_gym.config.deltas import merge
from hazbot_gym.core.state import Floats
from hazbot_gym.envs.registration import ENVIRONMENTS
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.evaluation.metrics import measure
from hazbot_gym.evaluation.oracle.best_drives import Pace, optima, plan_of, searched
from hazbot_gym.evaluation.oracle.dynamic_programming import is_exact_for
from hazbot_gym.evaluation.oracle.lattice import LEVELS
from hazbot_gym.evaluation.oracle.trajectory_search import Effort, Found
from hazbot_gym.evaluation.statistics.normalised_score import normalised_score
from hazbot_gym.policies import make
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Actions, Observations
from hazbot_gym.policies.sweeps import sweep
from hazbot_gym.task.action import action_of_speed, nearest_level
from hazbot_gym.utils import processors
from hazbot_gym.utils.json_object import JsonObject

QUIET_DRIVE = {"wheel_loop": "ideal", "wheel_noise_radps": 0.0, "heading_noise_rad": 0.0}
EXPERT, BEST = "fuzzy_expert", "best drive known"
FULL_SPEED = "constant:fraction=1"  # a robot that sees no one
RULES = (
    "stop_on_sight", "hall_steps", "social_force", "ssm:mode=strict", "ssm:mode=directional", "ttc",
    "passive_safety", "idm", "velocity_obstacle", "mpc", EXPERT,
)  # fmt: skip
# In environments with gas: rules about gas at two slow speeds, alone and beside rules about people
GAS_RULES = (
    EXPERT,
    "idm",
    *(
        f"{rule}:slow={slow:g},people={people}"
        for people in ("none", EXPERT, "idm")
        for rule in ("slow_on_rise", "undo_lag")
        for slow in (0.05, 0.2)
    ),
)
CONSTANTS = tuple(f"constant:fraction={each:g}" for each in (1.0, 0.8, 0.6, 0.4, 0.2))  # with gas
SLOW_STARTS = slice(3, None)  # of these, from which the search for leaks starts, too
FRACTIONS, STOPS_M = (1.0, 0.8, 0.6, 0.4), (0.0, 0.3, 0.5, 0.8, 1.2, 2.0)  # grid of the zero
EXPERT_AT_MOST, RULE_AT_MOST = 0.70, 0.85  # of the span, in an environment with headroom
GAS_EXPERT_AT_MOST = 0.60  # the same with gas, to which the expert is blind
LEVELS_OF_PAPER = ("stop", "25 %", "50 %", "75 %", "100 %")  # speed levels of the paper
DRAWS, LEVEL = 1000, 0.95  # of the bootstrap over scenarios
TUNED_FROM = 1_000_000  # first seed of the scenarios for tuning
UNITS = ("delay_s", "discomfort_s", "personal_m", "person_delay_s")  # plain metrics of a drive
GAS_UNITS = ("leak_found", "false_alarms")  # the same with gas


class OnLattice:
    """Policy wrapper that rounds commands to the speeds of the lattice."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    def predict(
        self,
        observation: Observations,
        state: object = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, object]:
        """Return the rounded action; see ``policies.base.Policy``."""
        actions, state = self._policy.predict(observation, state, episode_start, deterministic)
        return (2.0 * nearest_level(actions, LEVELS) / (LEVELS - 1) - 1.0).astype(np.float32), state


class Scenarios(NamedTuple):
    """Scenarios of an environment: the config, and the seeds of the resets."""

    config: Config
    seeds: list[int]


class Played(NamedTuple):
    """A policy's episodes in some scenarios."""

    spec: str
    episodes: list[Episode]
    keys: list[int]  # of the scenarios

    @property
    def returns(self) -> Floats:
        """Returns, (episodes,)."""
        return np.array([episode.rewards.sum() for episode in self.episodes])

    @property
    def contacts(self) -> float:
        """Share of episodes that end in a contact caused by the robot."""
        return float(np.mean([episode.contact_caused_by == "robot" for episode in self.episodes]))


class Size(NamedTuple):
    """Numbers of scenarios, the search budget, and the families of rules."""

    episodes: int  # for evaluation
    tuning: int  # for tuning
    effort: Effort
    rules: tuple[str, ...] = RULES  # families to compare


def environments(*, has_gas: bool = False) -> list[str]:
    """Return the environments with simulated people, those with gas or those without."""
    return [
        name
        for name, (_, preset) in ENVIRONMENTS.items()
        if "model" not in _people(preset) and ("gas" in preset) == has_gas
    ]


def has_gas(names: Sequence[str]) -> bool:
    """Return True if environments have gas; their rules, and so their records, differ.

    Raises:
        InvalidInput: Some have gas and some have none.
    """
    some = [name for name in names if name in environments(has_gas=True)]
    if some and len(some) < len(names):
        raise InvalidInput(
            f"env: given {', '.join(names)}, allowed are environments with gas "
            f"({', '.join(environments(has_gas=True))}) or without, each with rules of its own"
        )
    return bool(some)


def headroom_config(
    name: str, overrides: Mapping[str, object] = MappingProxyType({}), *, is_scripted: bool = False
) -> Config:
    """Return an environment's config; for the exact optimum people are scripted, wheels ideal.

    Raises:
        InvalidInput: The overrides contradict the conditions of the exact optimum.
    """
    quiet: JsonObject = {"people": {"model": "scripted"}, "drive": QUIET_DRIVE}
    config = make_config(
        merge(quiet if is_scripted else {}, overrides), preset=ENVIRONMENTS[name][1]
    )
    if is_scripted and not is_exact_for(config):
        raise InvalidInput(
            f"--scripted: given people.model {config.people.model!r}, drive.wheel_loop "
            f"{config.drive.wheel_loop!r}{' and gas' * (config.gas is not None)}, the exact "
            "optimum needs 'scripted', 'ideal', and no gas, noise, latency, reflex stop or line "
            "sensor"
        )
    return config


def settings(
    size: Size, overrides: Mapping[str, object] = MappingProxyType({}), *, is_scripted: bool = False
) -> JsonObject:
    """Return the settings of a record; records with equal settings can be continued."""
    return {
        "episodes": size.episodes,
        "tuning": size.tuning,
        "search": None if is_scripted else size.effort._asdict(),
        "families": list(size.rules),
        "level": LEVEL,
        "overrides": dict(overrides),
    }


def headroom(
    name: str,
    size: Size,
    overrides: Mapping[str, object] = MappingProxyType({}),
    *,
    is_scripted: bool = False,
    on_progress: Callable[[], None] = lambda: None,
) -> JsonObject:
    """Return the span of an environment, and the position of every family of rules within it.

    Args:
        name: of the environment, without the namespace.
        size: numbers of scenarios, and the search budget.
        overrides: deltas on the environment's config.
        is_scripted: whether people do not react and wheels are ideal, for the exact optimum.
        on_progress: called after each scenario's best drive.

    Raises:
        InvalidInput: The overrides contradict the conditions of the exact optimum.
    """
    config = headroom_config(name, overrides, is_scripted=is_scripted)
    tuning = Scenarios(config, [TUNED_FROM + i for i in range(size.tuning)])
    test = Scenarios(config, list(range(size.episodes)))
    zero = play(test, _zero(tuning).spec) if config.gas is not None else _zero(test)
    expert, full_speed = play(test, EXPERT), play(test, FULL_SPEED)
    played = {family: play(test, _tuned(tuning, family)) for family in size.rules}
    starts = [zero, expert, full_speed, *played.values()]
    steady = [] if config.gas is None else [play(test, spec) for spec in CONSTANTS]
    starts += steady[SLOW_STARTS]
    found = best_drives(test, starts, size.effort, on_progress)
    top = np.array([each.value for each in found])
    halfway = np.array([each.halfway for each in found])

    def row(run: Played) -> JsonObject:
        own, low = run.returns, zero.returns
        return {
            **_row(run),
            "share": float(normalised_score(own.mean(), low.mean(), top.mean())),
            "interval": interval(own, low, top),
            "share_halfway": float(normalised_score(own.mean(), low.mean(), halfway.mean())),
        }

    return {
        **({"constants": [_row(run) for run in steady]} if steady else {}),
        "full_speed_contacts": full_speed.contacts,
        "zero": _row(zero),
        "best": _row(play(test, plan_of(found), name=BEST)) | {"bound": float(top.mean())},
        "expert": row(expert),
        "best_rule": max(played, key=lambda family: played[family].returns.mean()),
        "rules": {family: row(run) for family, run in played.items()},
        "speeds": speed_shares(each.actions for each in found),
        "speeds_of_expert": speed_shares(_speeds(config, each) for each in expert.episodes),
    }


def play(scenarios: Scenarios, spec: str | Policy, *, name: str = "") -> Played:
    """Return a policy's episodes; on the exact optimum's scenarios with its speeds alone."""
    policy = make(spec) if isinstance(spec, str) else spec
    if is_exact_for(scenarios.config):
        policy = OnLattice(policy)
    runs = list(
        batch_rollout.run_episodes(
            scenarios.config, policy, scenarios.seeds, limit=scenarios.config.max_episode_steps,
            threads=processors.usable(),
        )
    )  # fmt: skip
    keys = [int(labels["scenario_key"]) for _, labels in runs]
    return Played(spec if isinstance(spec, str) else name, [episode for episode, _ in runs], keys)


def best_drives(
    scenarios: Scenarios,
    played: Sequence[Played],
    effort: Effort,
    on_progress: Callable[[], None] = lambda: None,
) -> list[Found]:
    """Return the best drive known of every scenario.

    Args:
        scenarios: the scenarios.
        played: results that initialize the search, one policy each.
        effort: search budget.
        on_progress: called after each scenario.
    """
    pace = Pace(processors.usable(), on_progress)
    if is_exact_for(scenarios.config):
        return optima(scenarios.config, played[0].keys, pace)
    drives = [run.episodes for run in played]
    return searched(scenarios.config, scenarios.seeds, drives, effort, pace)


def _people(preset: JsonObject) -> JsonObject:
    people: dict[str, object] = preset.get("people", {})
    return people


def _speeds(config: Config, episode: Episode) -> Floats:
    """Return the actions that command the driven speeds."""
    return action_of_speed(episode.speed_mps[1:], config.drive.nominal_speed_mps)


def _row(played: Played) -> JsonObject:
    measured = [measure(episode) for episode in played.episodes]
    units = (*UNITS, *(GAS_UNITS if "leak" in measured[0] else ()))
    return {
        "policy": played.spec,
        "return": float(played.returns.mean()),
        "arrived": float(np.mean([each["arrived"] for each in measured])),
        "contacts": played.contacts,
        **{unit: float(np.nanmean([each[unit] for each in measured])) for unit in units},
    }


def _zero(test: Scenarios) -> Played:
    """Return the best constant speed with a protective stop that makes no contact there.

    It is chosen in hindsight, on the scenarios of the evaluation, which makes the span shorter.
    With gas, where chance decides on each leak, the best of many would be a lucky one, and it is
    chosen on the scenarios for tuning.
    """
    played = [
        play(test, f"stop_when_near:fraction={fraction:g},stop_m={stop_m:g}")
        for fraction in FRACTIONS
        for stop_m in STOPS_M
    ]
    return max(played, key=lambda run: (-run.contacts, run.returns.mean()))


def _tuned(tuning: Scenarios, family: str) -> str:
    """Return a family's best member on these scenarios."""
    played = [play(tuning, spec) for spec in sweep(family)]
    return max(played, key=lambda run: run.returns.mean()).spec


def interval(returns: Floats, low: Floats, top: Floats) -> list[float]:
    """Return the bootstrap interval of a normalized mean return, over scenarios.

    The span is resampled with the policy.
    """
    rows = np.random.default_rng(0).integers(len(returns), size=(DRAWS, len(returns)))
    means = (each[rows].mean(axis=1) for each in (returns, low, top))
    tail = (1.0 - LEVEL) / 2.0
    bounds = np.nanquantile(normalised_score(*means), (tail, 1.0 - tail))
    return [float(bound) for bound in bounds]


def speed_shares(actions: Iterable[Floats]) -> list[float]:
    """Return the share of decisions at each of ``LEVELS_OF_PAPER``, rounded to the nearest."""
    shares = (np.concatenate(list(actions)).clip(-1.0, 1.0) + 1.0) / 2.0
    nearest = np.rint(shares * (len(LEVELS_OF_PAPER) - 1)).astype(np.int64)
    counts = np.bincount(nearest, minlength=len(LEVELS_OF_PAPER)) / max(len(nearest), 1)
    return [float(count) for count in counts]
