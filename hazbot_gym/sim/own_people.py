"""People who walk by a model of a user (``core/own_walking.py``)."""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.hooks import call
from hazbot_gym.core.jit import routine
from hazbot_gym.core.noise import CROWD, uniform4, uniform_noise
from hazbot_gym.core.social_force import Reaction
from hazbot_gym.core.state import Place, Records, RobotRecord
from hazbot_gym.sim.spacing import keep_apart
from hazbot_gym.sim.walking import blocked_share, walking_direction


@routine
def walk_by_own_model(
    model: int, people: Records, i: int, place: Place, robot: RobotRecord, reaction: Reaction,
    key: np.uint64, step: int, dt_s: float,
) -> None:  # fmt: skip
    """Set person i's next velocity by the model at an address, limited towards obstacles.

    Args:
        model: Address of the compiled model.
        people: (P,) PERSON records.
        i: Index of the person.
        place: Walls and routes.
        robot: The robot's record.
        reaction: Reaction of the person to the robot.
        key: Key of the scenario's noise.
        step: Number of this social step since the reset.
        dt_s: Social period [s].
    """
    me = people[i]
    ex, ey = walking_direction(me, place.routes)
    u1, u2, _, _ = uniform4(key, CROWD, step, i)
    call(
        model, me, people, i, robot, place.walls, ex, ey, reaction, dt_s, uniform_noise(u1),
        uniform_noise(u2),
    )  # fmt: skip
    me.blocked = blocked_share(
        robot.x - me.x, robot.y - me.y, me.vx * ex + me.vy * ey, me.desired_speed, me.radius, ex, ey
    )
    keep_apart(people, i, place, robot, dt_s)
