"""Settings of a run on the page, and what they are in the words of ``hazbot eval``.

A link to a run holds them, so equal settings are the same scenario with the same policy.
"""

from __future__ import annotations

import inspect
import shlex
from collections.abc import Iterator
from typing import Annotated, Literal

import yaml
from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator

from hazbot_gym.config import SCENARIOS, Config, Tracker, make_config
from hazbot_gym.config.deltas import merge
from hazbot_gym.config.section import Section
from hazbot_gym.core.ultrasonic import Ultrasonic
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE, full_id
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.field_types import MOST_EPISODES
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.task.places import PLACES

YOU = "you"  # the policy of a person at the page
NO_GHOST = ""
# Recorded people follow their track, whatever is done to them.
ENVS = tuple(name for name in ENVIRONMENTS if not name.startswith("Replay"))
CORRIDOR = ENVS[0]
PAPER = ("E*", "C*")  # scenarios of the paper: a person comes the other way, or crosses
MOST_SEED = 2**53 - 1  # the largest integer of a browser
MOST_PEOPLE, MOST_NOISE, MOST_LATENCY = 12, 5.0, 10
MOST_PRICE = 1000.0  # of nearness; a policy has a range of its own within


def _offered(env: str) -> str:
    if env in PAPER:
        return env
    short = full_id(env).removeprefix(f"{NAMESPACE}/")
    if short not in ENVS:
        raise InvalidInput(f"given {env!r}, allowed are {', '.join(ENVS)}")
    return short


class Settings(Section):
    """Settings of a run on the page; None is the environment's own value."""

    env: Annotated[str, AfterValidator(_offered)] = "Corridor-v1"
    seed: Annotated[int, Ge(0), Le(MOST_SEED)] = 0  # root of the seeds, as in ``hazbot eval``
    episode: Annotated[int, Ge(0), Le(MOST_EPISODES - 1)] = 0  # which of its episodes
    policy: str = "fuzzy_expert"
    ghost: str = NO_GHOST  # a second policy in a copy of the scenario
    tier: Literal["tracks", "sonar"] = "tracks"
    width_m: Annotated[float, Ge(1.4), Le(4.0)] | None = None  # of the place
    people: Annotated[int, Ge(0), Le(MOST_PEOPLE)] | None = None
    unyielding: Annotated[float, Ge(0), Le(1)] | None = None  # share of people who do not yield
    noise: Annotated[float, Ge(0), Le(MOST_NOISE)] = 1.0  # factor of the sensors' noise
    latency: Annotated[int, Ge(0), Le(MOST_LATENCY)] = 0  # of commands, in decisions
    # of nearness, s of delay per s of discomfort; for policies that observe it
    price: Annotated[float, Gt(0), Le(MOST_PRICE)] | None = None

    def overrides(self) -> dict[str, object]:
        """Return the config values that differ from the environment's own."""
        values: dict[str, object] = {"scenario": self.env} if self.env in PAPER else {}
        if self.tier != "tracks":
            values["tier"] = self.tier
        if self.width_m is not None:
            values["place_options"] = {"width_m": self.width_m}
        people: dict[str, object] = {}
        if self.people is not None:
            people["count"] = [self.people, self.people]
        if self.unyielding is not None:
            people["reaction_shares"] = [round(1.0 - self.unyielding, 6), self.unyielding, 0.0, 0.0]
        if people:
            values["people"] = people
        if self.noise != 1.0:
            values["sensors"] = _sensors(self.noise)
        if self.latency:
            values["drive"] = {"latency_steps": self.latency}
        return values

    def scenarios(self) -> ScenarioSet:
        """Return the scenario set of the environment, with the seeds of ``hazbot eval``."""
        name = self.env.rsplit("-v", 1)[0]
        return ScenarioSet(name=name, env=self._id(), overrides=self.overrides())

    def _id(self) -> str:
        return CORRIDOR if self.env in PAPER else self.env

    def is_same_scenario(self, other: Settings) -> bool:
        """Return True if only the policies differ."""
        policies = {"policy": self.policy, "ghost": self.ghost, "price": self.price}
        return other.model_copy(update=policies) == self

    def is_same_ten(self, other: Settings) -> bool:
        """Return True if only policies and episode differ."""
        return self.model_copy(update={"episode": other.episode}).is_same_scenario(other)

    def command(self, policy: str | None = None) -> str:
        """Return the command that measures the policy in the episodes up to this one.

        Args:
            policy: Spec of the policy at the price; default the one of these settings.
        """
        policy = policy or self.policy
        words = ["hazbot", "eval", "--policy", policy, "--env", self._id()]
        words += ["--episodes", str(self.episode + 1), "--seed", str(self.seed)]
        for name, value in _flat(self.overrides()):
            words += ["--set", f"{name}={value}"]
        return shlex.join(words)

    def scene(self, policy: str | None = None) -> str:
        """Return the config of the environment as YAML, for ``config=`` of ``gymnasium.make``."""
        overrides = self.overrides()
        named = SCENARIOS[str(overrides.pop("scenario"))] if self.env in PAPER else {}
        whole = merge(merge(ENVIRONMENTS[self._id()][1], named), overrides)
        head = (
            f"# {self.env} as set on the page of hazbot play: gymnasium.make(..., config=FILE)"
            f"\n# {self.command(policy)}\n"
        )
        return head + yaml.safe_dump(whole, sort_keys=False)


def default_config(env: str) -> Config:
    """Return an environment's own config."""
    return make_config(scenario=env) if env in PAPER else make_config(preset=ENVIRONMENTS[env][1])


def default_width_m(config: Config) -> float | None:
    """Return the width of a config's place, None where it has none."""
    width = inspect.signature(PLACES[config.place]).parameters.get("width_m")
    return None if width is None else float(width.default)


def _sensors(noise: float) -> dict[str, object]:
    """Return sensors with some times the noise of the default ones."""
    tracker = Tracker()
    return {
        "ultrasonic": {"noise_m": round(noise * Ultrasonic().noise_m, 6)},
        "tracker": {
            "position_noise_m": round(noise * tracker.position_noise_m, 6),
            "velocity_noise_mps": round(noise * tracker.velocity_noise_mps, 6),
        },
    }


def _flat(values: dict[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield nested values by dotted name."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
