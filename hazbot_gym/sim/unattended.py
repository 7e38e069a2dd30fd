"""Pedestrians-only simulation, without the robot."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hazbot_gym.core.hooks import NO_HOOK
from hazbot_gym.core.jit import lean_kernel
from hazbot_gym.core.recorded_table import NO_STRETCH, Stretch
from hazbot_gym.core.social_force import ATTENTIVE, SocialForce
from hazbot_gym.core.state import PERSON, ROBOT, Place, Records, as_record, records
from hazbot_gym.sim.people import move_people, social_step
from hazbot_gym.sim.walkers import Workspace, make_workspace

FAR_AWAY_M = 1e6  # position of a robot out of everyone's reach


def walk_unattended(
    people: Records, place: Place, force: SocialForce, *,
    key: int, steps: int, dt_s: float, own_model: int = NO_HOOK,
) -> Records:  # fmt: skip
    """Simulate people only; return (steps, P) PERSON records at every social step.

    Args:
        people: (P,) PERSON records at time zero, changed in place.
        place: Walls and routes.
        force: Constants of the walking model.
        key: Key of the fluctuations.
        steps: Number of social steps.
        dt_s: Social period [s].
        own_model: Address of a user's pedestrian model.
    """
    return next(
        walk_in_parts(
            people, place, force, key=key, steps=steps, dt_s=dt_s, part=steps, own_model=own_model
        )
    )


def walk_in_parts(
    people: Records, place: Place, force: SocialForce, *,
    key: int, steps: int, dt_s: float, part: int, own_model: int = NO_HOOK,
) -> Iterator[Records]:  # fmt: skip
    """Yield the result of ``walk_unattended`` in chunks of ``part`` steps."""
    robot = records(ROBOT, 1)
    robot["x"] = FAR_AWAY_M
    # One for every possible reaction; compiled code does not check an index.
    reactions = np.repeat(as_record(ATTENTIVE), 1 + people["reaction"].max(initial=0))
    work = make_workspace(len(people))
    for first in range(0, steps, part):
        seen = np.zeros((min(part, steps - first), len(people)), PERSON)
        _walk(
            people, place, robot, as_record(force), reactions, own_model, NO_STRETCH,
            np.uint64(key), first, dt_s, work, seen,
        )  # fmt: skip
        yield seen


@lean_kernel
def _walk(
    people: Records, place: Place, robot: Records, force: Records, reactions: Records,
    own_model: int, recording: Stretch, key: np.uint64, first: int, dt_s: float, work: Workspace,
    seen: Records,
) -> None:  # fmt: skip
    for k in range(seen.shape[0]):
        social_step(
            people, place, robot[0], force[0], reactions, own_model, recording, key, first + k,
            dt_s, work,
        )  # fmt: skip
        for i in range(people.shape[0]):
            seen[k, i] = people[i]
        move_people(people, dt_s)
