"""Policy protocol, and construction of policies from a spec string.

A policy implements Stable-Baselines3's ``predict``, so that rules and trained models run by the
same code. Its action is always continuous; a discrete environment uses the nearest level.
"""

from __future__ import annotations

import dataclasses
import importlib
import os
from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt
from pydantic import ConfigDict, ValidationError

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies import own_module
from hazbot_gym.policies.guard import Actions, Flags, Guarded, Observations
from hazbot_gym.policies.own_policy import OwnPolicy
from hazbot_gym.task.action import speed_action
from hazbot_gym.utils.json_object import JsonObject

OPTIONS = ConfigDict(extra="forbid", allow_inf_nan=False)  # of the dataclasses of policies


@runtime_checkable
class Policy(Protocol):
    """Policy: chooses the robot's speed from observations.

    Policies of the library return -1, stop, for invalid observations (``guard``).
    """

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Any]:
        """Return the action and the policy's next inner state.

        Args:
            observation: (n,) of one environment or (N, n) of several.
            state: Inner state of the last call; None for policies without one.
            episode_start: (N,) whether each environment has just been reset.
            deterministic: Whether to return the most likely action instead of a sample.

        Returns:
            Actions in [-1, 1], -1 = stop, +1 = nominal speed, shape (1,) or (N, 1); and the state.
        """
        ...


class Rule(Guarded):
    """A stateless policy: maps observations to a share of the nominal speed."""

    def speed_share(self, observation: Observations) -> npt.ArrayLike:
        """Return the share in [0, 1] for observations (..., n): shape (...)."""
        raise NotImplementedError

    def act(
        self, observation: Observations, state: object, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, object]:
        """Return the action, and the state unchanged; see ``Guarded.act``."""
        return speed_action(self.speed_share(observation)), state


class Entry(NamedTuple):
    """A policy of the register."""

    factory: str  # "module:class", imported on first use
    description: str


REGISTER = {
    "constant": Entry(
        "hazbot_gym.policies.constant:Constant",
        "constant speed; fraction=0..1 of nominal",
    ),
    "random": Entry(
        "hazbot_gym.policies.random_speed:RandomSpeed",
        "a speed drawn uniformly for each decision; seed=",
    ),
    "stop_on_sight": Entry(
        "hazbot_gym.policies.stop_on_sight:StopOnSight",
        "stops if an ultrasonic sensor in front reads less than stop_m=, until resume_m=",
    ),
    "stop_when_near": Entry(
        "hazbot_gym.policies.stop_when_near:StopWhenNear",
        "stops while a person is nearer than stop_m=, else drives at fraction=0..1 of nominal",
    ),
    "ssm": Entry(
        "hazbot_gym.policies.ssm:Ssm",
        "speed and separation monitoring; mode=strict|directional, margin_m=, nominal_mps=",
    ),
    "ttc": Entry(
        "hazbot_gym.policies.ttc:Ttc",
        "largest speed without a collision within horizon_s=; margin_m=, nominal_mps=",
    ),
    "hall_steps": Entry(
        "hazbot_gym.policies.hall_steps:HallSteps",
        "the speed of the nearest person's Hall zone; scale= of the zones",
    ),
    "passive_safety": Entry(
        "hazbot_gym.policies.passive_safety:PassiveSafety",
        "stops before a person walking at obstacle_mps= can reach it; nominal_mps=",
    ),
    "idm": Entry(
        "hazbot_gym.policies.idm:Idm",
        "car following of people in its lane; headway_s=, lane_m=, gap_m=, nominal_mps=",
    ),
    "velocity_obstacle": Entry(
        "hazbot_gym.policies.velocity_obstacle:VelocityObstacle",
        "largest speed without a person nearer than margin_m= within horizon_s=; "
        "responsibility=, nominal_mps=",
    ),
    "mpc": Entry(
        "hazbot_gym.policies.mpc:Mpc",
        "optimal plan for people at constant velocity; caution=, nearness=depth|discomfort, "
        "horizon_s=, nominal_mps=",
    ),
    "fuzzy_expert": Entry(
        "hazbot_gym.policies.fuzzy_expert:FuzzyExpert",
        "the paper's fuzzy strategy; rules=, pattern=, t_norm=, release=, scale=, horizon_s=",
    ),
    "fuzzy_reading": Entry(
        "hazbot_gym.policies.fuzzy_readings:FuzzyReading",
        "alternative readings of the paper's strategy; reading=inverted|gaussian|...",
    ),
    "social_force": Entry(
        "hazbot_gym.policies.social_force:SocialForceSpeed",
        "speed by the total social force along the path; strength=, nominal_mps=",
    ),
    "slow_on_rise": Entry(
        "hazbot_gym.policies.slow_on_rise:SlowOnRise",
        "with gas: slow= while the sensor's reading rises faster than rise_per_s=; people=",
    ),
    "undo_lag": Entry(
        "hazbot_gym.policies.undo_lag:UndoLag",
        "with gas: slow= while the sensor heads for a reading above level=; lag_s=, people=",
    ),
    "shielded": Entry(
        "hazbot_gym.policies.shielded:Shielded",
        "policy=ANY, at most as fast as the rule by= permits; policy= is last",
    ),
    "ppo": Entry(
        "hazbot_gym.policies.learned:Ppo",
        "the shipped PPO policy for the tier of the observations",
    ),
    "ppo_prices": Entry(
        "hazbot_gym.policies.learned:PpoPrices",
        "the shipped PPO policy for any price of nearness; price=1..16 s per s of discomfort",
    ),
    "learned": Entry(
        "hazbot_gym.policies.learned:Learned",
        "a trained policy; price= of nearness if it observes one; path=FILE.npz is last, or a .zip "
        "with --allow-pickle",
    ),
}


def names() -> dict[str, str]:
    """Return the name and a short description of every policy of the library."""
    return {name: entry.description for name, entry in REGISTER.items()}


class Permissions(NamedTuple):
    """Permissions of a policy named in a file: library code only, unless the user allows more."""

    allow_pickle: bool = False  # pickled code in a zip of Stable-Baselines3
    allow_code: bool = False  # modules of the user


NO_CODE = Permissions()


def make(spec: str, *, allow_pickle: bool = False, allow_code: bool = True) -> Policy:
    """Return the policy of a spec string.

    Args:
        spec: ``name`` or ``name:option=value,...`` with a name of the register, or
            ``module:attribute`` for a user policy: an object with ``predict``, or a factory without
            arguments. The path of ``learned:path=`` and the spec of ``shielded:policy=`` extend to
            the end of the line. Policies of the library stop on invalid observations (``guard``); a
            user policy is called unguarded, unless it is a ``guard.Guarded``, and its actions are
            checked.
        allow_pickle: Whether a ``learned`` zip may execute its pickled code.
        allow_code: Whether ``module:attribute`` may execute that module. Callers that read the spec
            from a file must ask the user first (``Permissions``).

    Raises:
        InvalidInput: an unknown name or option, a value or code that is not allowed, or no policy.
    """
    name, _, rest = spec.partition(":")
    if name in REGISTER:
        return _from_register(spec, name, rest, Permissions(allow_pickle, allow_code))
    if not own_module.is_reference(spec):
        raise InvalidInput(
            f"policy: {spec!r} is not known; allowed are {', '.join(REGISTER)} or module:attribute"
        )
    if not allow_code:
        raise InvalidInput(
            f"policy: {spec!r} comes from a file and would run the code of {name!r}; if you trust "
            "it, allow that with --allow-code on the command line, or allow_code=True in Python"
        )
    found = own_module.load(spec)
    policy = found
    if callable(found) and not _is_policy(found):
        with own_module.working_folder():
            policy = own_module.called(f"making {spec!r}", found)
    if not _is_policy(policy):
        raise InvalidInput(f"policy: {spec!r} has no predict(observation, state, ...) method")
    return OwnPolicy(spec, policy)


def spec_of(name: str, options: Mapping[str, object]) -> str:
    """Return the spec string of a registered policy with some options."""
    return f"{name}:{','.join(f'{option}={value}' for option, value in options.items())}"


def _is_policy(thing: object) -> bool:
    return isinstance(thing, Policy) and not isinstance(thing, type)


def factory_of(name: str) -> Any:
    """Return the dataclass behind a name of the register."""
    module, _, kind = REGISTER[name].factory.partition(":")
    return getattr(importlib.import_module(module), kind)


def _from_register(spec: str, name: str, text: str, allowed: Permissions) -> Policy:
    factory = factory_of(name)
    options: JsonObject
    if name == "learned":
        options = {**_file_in(spec, text), "allow_pickle": allowed.allow_pickle}
    elif name == "shielded":
        options = {**_shield_in(spec, text), **allowed._asdict()}
    else:
        options = _parse_options(spec, text, [field.name for field in dataclasses.fields(factory)])
    try:
        policy: Policy = factory(**options)
    except ValidationError as error:
        first = error.errors()[0]
        cause = first.get("ctx", {}).get("error")
        if isinstance(cause, InvalidInput):
            raise cause from None
        option = ".".join(str(part) for part in first["loc"])
        raise InvalidInput(
            f"policy {spec!r}: {option} = {first['input']!r} is not allowed: {first['msg']}"
        ) from None
    return policy


def _file_in(spec: str, text: str) -> dict[str, str]:
    """Return the options of ``learned``; its path, which may contain any character, is last."""
    options = dict[str, str]()
    if text.startswith("price="):
        options["price"], _, text = text.removeprefix("price=").partition(",")
    path = text.removeprefix("path=")
    if not path:
        raise InvalidInput(f"policy: {spec!r} names no file; give learned:path=FILE")
    if ",allow_pickle=" in path and not os.path.exists(path):
        raise InvalidInput(
            f"policy: {spec!r} cannot allow itself pickle; give --allow-pickle on the command "
            "line, or allow_pickle=True in Python"
        )
    if ",price=" in path and not os.path.exists(path):
        raise InvalidInput(f"policy: {spec!r} ends in a price; give learned:price=P,path=FILE")
    return {**options, "path": path}


def _shield_in(spec: str, text: str) -> dict[str, str]:
    """Return the options of ``shielded``; those of its policy extend to the end."""
    head, named, policy = text.partition("policy=")
    if not named:
        raise InvalidInput(f"policy: {spec!r} names no policy; give shielded:policy=SPEC")
    return {**_parse_options(spec, head.rstrip(","), ["by"]), "policy": policy}


def _parse_options(spec: str, options: str, allowed: list[str]) -> dict[str, str]:
    """Split ``a=1,b=2``; a value without a name is positional."""
    parsed: dict[str, str] = {}
    for place, item in enumerate(options.split(",") if options else []):
        name, equals, value = (part.strip() for part in item.partition("="))
        if not equals:
            name, value = (allowed[place] if place < len(allowed) else item), name
        if name not in allowed or name in parsed:
            reason = "given twice" if name in parsed else "not known"
            raise InvalidInput(
                f"policy {spec!r}: option {name!r} is {reason}; allowed are {', '.join(allowed)}"
            )
        parsed[name] = value
    return parsed
