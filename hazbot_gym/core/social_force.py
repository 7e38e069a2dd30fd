"""Social force model of people among people, walls and a robot (paper eqs 7, 8a).

    dv/dt = (v0 e - v)/tau + sum_b w(e, f_b) f_b + sum_walls f_w + w(e, f_r) f_r + f_sidestep

All terms are accelerations: mass is left out as in Helbing and Molnar 1995, "Social force model for
pedestrian dynamics", Phys. Rev. E 51, 4282 (HM95). Four constants are calibrated on people recorded
in corridors (``calibration/fit.py``, docs/people.md), the others are those of HM95 unless noted.
The elliptical repulsion takes the relative step (Johansson, Helbing and Shukla 2007, "Specification
of the social force pedestrian model by evolutionary adjustment to video tracking data", eq 5), so
that people anticipate each other. Left out: groups, and panic.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Le

from hazbot_gym.core.elementary import decay, sin_cos
from hazbot_gym.core.geometry import norm
from hazbot_gym.core.jit import scalar


class SocialForce(NamedTuple):
    """Constants of the walking model."""

    relaxation_time_s: Annotated[float, Gt(0)] = 0.5  # tau (HM95)
    # v0 for which the constants below hold (HM95); forces are in proportion to a person's own v0
    typical_speed_mps: Annotated[float, Gt(0)] = 1.34
    speed_limit_ratio: Annotated[float, Ge(1)] = 1.3  # v_max / v0 (HM95)
    person_strength_mps2: Annotated[float, Ge(0)] = 4.91  # V0/sigma (calibrated; HM95: 7)
    person_range_m: Annotated[float, Gt(0)] = 0.0685  # sigma (calibrated; HM95: 0.3 m)
    step_time_s: Annotated[float, Ge(0)] = 2.3  # step time (calibrated)
    wall_strength_mps2: Annotated[float, Ge(0)] = 5.0  # U0/R; HM95: 50, for wide halls
    wall_range_m: Annotated[float, Gt(0)] = 0.1  # R; HM95: 0.2 m
    # Response to the robot, calibrated on encounters (docs/encounters.md)
    robot_strength_mps2: Annotated[float, Ge(0)] = 7.15
    robot_range_m: Annotated[float, Gt(0)] = 0.186
    robot_step_time_s: Annotated[float, Ge(0)] = 0.116
    robot_sidestep_mps2: Annotated[float, Ge(0)] = 0.0951
    anisotropy: Annotated[float, Ge(0), Le(1)] = 0.5  # c, weight outside the field of view (HM95)
    view_angle_rad: Annotated[float, Gt(0)] = math.radians(100.0)  # phi, to each side (HM95)
    sidestep_mps2: Annotated[float, Ge(0)] = 0.812  # stepping aside when met head-on (calibrated)
    sidestep_range_m: Annotated[float, Gt(0)] = 3.0  # from where on (surface to surface)
    jitter_mps2: Annotated[float, Ge(0)] = 0.2  # fluctuation term of HM95, uniform: sd per step


HELBING_MOLNAR_1995 = SocialForce(  # as published, for people who meet outdoors
    person_strength_mps2=7.0,
    person_range_m=0.3,
    step_time_s=2.0,
    wall_strength_mps2=50.0,
    wall_range_m=0.2,
    robot_strength_mps2=7.0,
    robot_range_m=0.3,
    robot_step_time_s=2.0,
    robot_sidestep_mps2=0.0,
    sidestep_mps2=0.0,
)


class Reaction(NamedTuple):
    """Reaction of a person to the robot; named after the reactions of HuNavSim."""

    gain: Annotated[float, Ge(0)] = 1.0  # factor of the repulsion from the robot
    range_m: Annotated[float, Ge(0)] = 3.0  # clearance from which it is noticed (calibrated)
    attraction_mps2: Annotated[float, Ge(0)] = 0.0  # pull towards it (eq 8a's F_att), beyond 1.2 m


ATTENTIVE = Reaction()
BLIND = Reaction(range_m=0.0)  # does not yield: looks at a phone, or walks in a stream
WARY = Reaction(gain=1.5, range_m=6.0)  # keeps away; at 2.5 it would not pass in 2 m at all
CURIOUS = Reaction(gain=0.6, range_m=4.0, attraction_mps2=0.4)  # comes to have a look


@scalar
def goal_force(
    vx: float, vy: float, ex: float, ey: float, desired_speed: float, relaxation_time_s: float
) -> tuple[float, float]:
    """Return (v0 e - v)/tau, the pull towards the desired velocity (HM95 eq 2) [m/s^2]."""
    return (
        (desired_speed * ex - vx) / relaxation_time_s,
        (desired_speed * ey - vy) / relaxation_time_s,
    )


@scalar
def elliptical_repulsion(
    nx: float, ny: float, distance: float, sx: float, sy: float, strength: float, range_m: float
) -> tuple[float, float]:
    """Return the elliptical repulsion of another person at -r with relative step s [m/s^2].

    f = -grad_r V(b), V = V0 exp(-b/sigma), 2b = sqrt((|r| + |r - s|)^2 - |s|^2)   (HM95 eqs 3, 4)
      = V0/sigma exp(-b/sigma) (|r| + |r - s|)/(4b) (r/|r| + (r - s)/|r - s|)

    Args:
        nx: r/|r|, the unit vector from the other to oneself.
        ny: The same, other axis.
        distance: |r|, surface to surface [m].
        sx: Relative step (v_other - v_self) * step time [m].
        sy: The same, other axis [m].
        strength: V0/sigma [m/s^2].
        range_m: sigma [m].
    """
    ahead_x, ahead_y = distance * nx - sx, distance * ny - sy
    ahead = max(norm(ahead_x, ahead_y), 1e-6)
    total = distance + ahead
    b = 0.5 * math.sqrt(max(total * total - sx * sx - sy * sy, 1e-8))
    magnitude = strength * decay(-b / range_m) * total / (4.0 * b)
    # Near the axis of the ellipse the gradient is unbounded; this caps the acceleration.
    magnitude = min(magnitude, strength)
    share = magnitude / ahead
    return magnitude * nx + share * ahead_x, magnitude * ny + share * ahead_y


@scalar
def view_weight(ex: float, ey: float, fx: float, fy: float, force: SocialForce) -> float:
    """Return w(e, f): 1 if the cause of force f is in view, else c (HM95 eqs 8, 9)."""
    in_view = -(ex * fx + ey * fy) >= norm(fx, fy) * sin_cos(force.view_angle_rad)[1]
    return 1.0 if in_view else force.anisotropy


@scalar
def wall_force(
    nx: float, ny: float, distance: float, strength: float, range_m: float
) -> tuple[float, float]:
    """Return the repulsion from the nearest point of a wall, U0/R exp(-d/R) n (HM95 eq 5) [m/s^2].

    Args:
        nx: Unit vector from the wall to the person.
        ny: The same, other axis.
        distance: From the wall to the person's surface [m].
        strength: U0/R [m/s^2].
        range_m: R [m].
    """
    magnitude = strength * decay(-max(distance, 0.0) / range_m)
    return magnitude * nx, magnitude * ny


@scalar
def sidestep_force(
    nx: float, ny: float, ex: float, ey: float, gap_m: float, strength_mps2: float, range_m: float
) -> tuple[float, float]:
    """Return the side-step acceleration of a walker for an obstacle ahead [m/s^2].

    With central repulsion alone, two exactly head-on walkers block each other. The step is
    perpendicular to the walking direction e, away from the obstacle, to the right if aligned, and
    stronger for nearer and more frontal obstacles: a (1 - gap/range) cos(bearing)^4.

    Args:
        nx: Unit vector from the walker to the obstacle's centre.
        ny: The same, other axis.
        ex: Walking direction, unit vector.
        ey: The same, other axis.
        gap_m: Distance between the surfaces [m].
        strength_mps2: Largest acceleration a [m/s^2].
        range_m: Distance between the surfaces from which it acts [m].
    """
    ahead = max(nx * ex + ny * ey, 0.0)
    side = 1.0 if ex * ny - ey * nx >= -1e-3 else -1.0  # the obstacle is on the left, or in line
    nearness = min(max(1.0 - max(gap_m, 0.0) / range_m, 0.0), 1.0)
    squared = ahead * ahead
    magnitude = side * strength_mps2 * nearness * (squared * squared)
    return magnitude * ey, -magnitude * ex
