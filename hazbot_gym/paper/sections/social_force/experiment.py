"""Section 3.2.1: the social forces of equations 7 and 8, on a walker and on the robot."""

from __future__ import annotations

from typing import NamedTuple

from hazbot_gym.core.geometry import norm
from hazbot_gym.core.social_force import (
    CURIOUS,
    HELBING_MOLNAR_1995,
    SocialForce,
    elliptical_repulsion,
    goal_force,
)
from hazbot_gym.core.state import PERSON_MASS_KG, PERSON_RADIUS_M, ROBOT_MASS_KG, ROBOT_RADIUS_M
from hazbot_gym.policies.people_seen import RADII_M

Vector = tuple[float, float]


class Forces(NamedTuple):
    """Forces of equation 7 on a body [N]."""

    acceleration: Vector  # F_acc, towards the desired velocity
    interaction: Vector  # F_int, away from the other
    attraction: Vector  # F_att, attraction

    @property
    def total(self) -> Vector:
        """Their sum."""
        return (sum(force[0] for force in self), sum(force[1] for force in self))


class Body(NamedTuple):
    """A body of the drawn situation."""

    x: float
    y: float
    vx: float
    vy: float
    desired_vx: float
    mass_kg: float


ROBOT = Body(0.0, 0.0, 0.35, 0.0, 0.5, ROBOT_MASS_KG)
HUMAN = Body(2.2, 0.6, -0.9, 0.0, -1.34, PERSON_MASS_KG)


def forces_on(
    me: Body, other: Body, attraction_mps2: float, constants: SocialForce = HELBING_MOLNAR_1995
) -> Forces:
    """Return the forces on one of two bodies; Helbing and Molnar's are per unit mass."""
    dx, dy = me.x - other.x, me.y - other.y
    distance = norm(dx, dy)
    nx, ny = dx / distance, dy / distance
    step = constants.step_time_s
    interaction = elliptical_repulsion(
        nx, ny, distance - RADII_M, (other.vx - me.vx) * step, (other.vy - me.vy) * step,
        constants.robot_strength_mps2, constants.robot_range_m,
    )  # fmt: skip
    acceleration = goal_force(me.vx, me.vy, 1.0, 0.0, me.desired_vx, constants.relaxation_time_s)
    m = me.mass_kg
    return Forces(
        (m * acceleration[0], m * acceleration[1]),
        (m * interaction[0], m * interaction[1]),
        (-m * attraction_mps2 * nx, -m * attraction_mps2 * ny),
    )


def drawn() -> dict[str, tuple[Body, Forces]]:
    """Return the situation of Figure 4: a curious human, and no attraction of the robot."""
    return {
        "robot": (ROBOT, forces_on(ROBOT, HUMAN, 0.0)),
        "human": (HUMAN, forces_on(HUMAN, ROBOT, CURIOUS.attraction_mps2)),
    }


def repulsion_mps2(clearance_m: float, constants: SocialForce) -> float:
    """Return the repulsion between two people without relative motion [m/s^2]."""
    force = elliptical_repulsion(
        1.0, 0.0, clearance_m, 0.0, 0.0, constants.person_strength_mps2, constants.person_range_m
    )
    return force[0]


BODY_RADII_M = {"robot": ROBOT_RADIUS_M, "human": PERSON_RADIUS_M}
