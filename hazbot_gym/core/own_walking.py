"""Pedestrian models of users, registered by name with ``@pedestrian_model``."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np

from hazbot_gym.core.hooks import NO_HOOK, Untyped, address_of, carray, check_hook
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.social_force import Reaction
from hazbot_gym.core.state import (
    PERSON,
    ROBOT,
    Floats,
    PersonRecord,
    Records,
    RobotRecord,
    as_record,
    records,
)
from hazbot_gym.errors import InvalidInput

BUILT_IN = ("scripted", "social_force", "replay", "seeded")
PARAMETERS = ("me", "situation")
Velocity = tuple[float, float]
Model = TypeVar("Model", bound=Callable[..., Velocity])


class Situation(NamedTuple):
    """Surroundings of a person, for a pedestrian model.

    Attributes:
        people: (P,) PERSON records of everyone, the person included.
        own_index: The person's own index among them.
        robot: The robot's record.
        walls: (W, 4) segments x1, y1, x2, y2 [m].
        ahead_x: Unit vector to the person's target ahead on its route.
        ahead_y: The same, other axis.
        reaction: The person's ``Reaction`` to the robot (``people.reactions`` in the config).
        dt_s: Time until the next velocity [s].
        noise_x: Noise of the scenario, uniform with mean 0 and standard deviation 1.
        noise_y: The same, other axis.
    """

    people: Records
    own_index: int
    robot: RobotRecord
    walls: Floats
    ahead_x: float
    ahead_y: float
    reaction: Reaction
    dt_s: float
    noise_x: float
    noise_y: float


PEDESTRIAN_MODELS: dict[str, Callable[..., Velocity]] = {}  # registered in this process


def pedestrian_model(function: Model) -> Model:
    """Register a function ``(me, situation)`` as a pedestrian model, named like the function.

    It returns the velocity until the next social step, world axes [m/s], from the person's record
    and ``Situation``; the velocity is then limited so that people do not walk into each other, into
    walls, or into the robot. Both engines compile it. Choose it by name in the config:
    ``people={"model": "name_of_the_function"}``.

    Raises:
        InvalidInput: The function takes other parameters, or has the name of a built-in model.
    """
    name = check_hook("pedestrian_model", function, PARAMETERS, BUILT_IN)
    PEDESTRIAN_MODELS[name] = function
    return scalar(function)


def check_model(name: str) -> str:
    """Raise ``ValueError`` for the name of no pedestrian model."""
    if name not in (*BUILT_IN, *PEDESTRIAN_MODELS):
        known = ", ".join(f"'{each}'" for each in (*BUILT_IN, *PEDESTRIAN_MODELS))
        raise ValueError(
            f"given {name!r}, allowed are {known}, and others that are registered with "
            "@pedestrian_model"
        )
    return name


def check_walk(model: str, people: Records) -> None:
    """Raise if a model of a user has moved people (..., P) to nowhere."""
    if model in PEDESTRIAN_MODELS and not np.isfinite(people["x"] + people["y"]).all():
        raise InvalidInput(f"pedestrian model {model!r}: gave a velocity that is not finite")


def address_of_model(name: str) -> int:
    """Return the address of a compiled model; ``NO_HOOK`` for those of the library.

    Raises:
        InvalidInput: It cannot be compiled.
    """
    if name not in PEDESTRIAN_MODELS:
        return NO_HOOK
    me, robot = records(PERSON, 1)[0], records(ROBOT, 1)[0]
    around = (
        records(PERSON, 1), 0, robot, np.zeros((1, 4)), 1.0, 0.0, as_record(Reaction())[0],
        0.1, 0.0, 0.0,
    )  # fmt: skip
    return address_of(
        f"pedestrian model {name!r}", PEDESTRIAN_MODELS[name],
        examples=(me, Situation(*around)), results=2, passed=(me, *around), adapted=_adapted,
    )  # fmt: skip


def _adapted(model: Callable[..., Velocity]) -> tuple[Callable[..., None], Callable[..., None]]:
    def plain(me: PersonRecord, *around: Untyped) -> None:
        me.next_vx, me.next_vy = model(me, Situation(*around))

    def entry(
        me: Untyped, people: Untyped, count: int, index: int, robot: Untyped, walls: Untyped,
        segments: int, ends: int, ahead_x: float, ahead_y: float, reaction: Untyped, dt_s: float,
        noise_x: float, noise_y: float,
    ) -> None:  # fmt: skip
        person = carray(me, (1,))[0]
        person.next_vx = np.nan  # what stays where the model raises
        vx, vy = model(
            person,
            Situation(
                carray(people, (count,)), index, carray(robot, (1,))[0],
                carray(walls, (segments, ends)), ahead_x, ahead_y, carray(reaction, (1,))[0],
                dt_s, noise_x, noise_y,
            ),
        )  # fmt: skip
        person.next_vx = vx
        person.next_vy = vy

    return plain, entry
