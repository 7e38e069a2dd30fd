"""People among themselves: how they walk where no robot is."""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.jit import lean_kernel
from hazbot_gym.core.social_force import ATTENTIVE, SocialForce
from hazbot_gym.core.state import PERSON, ROBOT, Floats, Place, Records, as_record, records
from hazbot_gym.sim.people import move_people, social_step
from hazbot_gym.sim.walkers import Bench, make_bench

FAR_AWAY_M = 1e6  # where a robot is that nobody meets


def walk_unattended(
    people: Records, place: Place, force: SocialForce, *, key: int, steps: int, dt_s: float
) -> Records:
    """Return everybody at every social step, as it is from then on: (steps, P) PERSON records.

    Args:
        people: (P,) PERSON records at time zero, changed in place.
        place: Walls and routes.
        force: Constants of the walking model.
        key: Key of the fluctuations.
        steps: How many social steps.
        dt_s: Social period [s].
    """
    robot = records(ROBOT, 1)
    robot["x"] = FAR_AWAY_M
    seen = np.zeros((steps, len(people)), PERSON)
    nobody_is_replayed = np.zeros((0, 0, 2))
    # One for every reaction that a person may carry; compiled code does not check an index.
    reactions = np.repeat(as_record(ATTENTIVE), 1 + people["reaction"].max(initial=0))
    _walk(
        people, place, robot, as_record(force), reactions, nobody_is_replayed,
        np.uint64(key), dt_s, make_bench(len(people)), seen,
    )  # fmt: skip
    return seen


@lean_kernel
def _walk(
    people: Records, place: Place, robot: Records, force: Records, reactions: Records,
    recording: Floats, key: np.uint64, dt_s: float, bench: Bench, seen: Records,
) -> None:  # fmt: skip
    for step in range(seen.shape[0]):
        social_step(people, place, robot[0], force[0], reactions, recording, key, step, dt_s, bench)
        for i in range(people.shape[0]):
            seen[step, i] = people[i]
        move_people(people, dt_s)
