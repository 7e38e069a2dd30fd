"""Section 3.1: kinematics and the castor."""

from __future__ import annotations

import math

from hazbot_gym.core.kinematics import Twist as Velocity
from hazbot_gym.core.kinematics import turning_radius, wheel_speeds
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.sections.kinematics import plots
from hazbot_gym.paper.sections.kinematics.experiment import (
    CHASSIS,
    PAPER_RATIO,
    castor_table,
    nearest_chassis_m,
)
from hazbot_gym.task.places import CIRCLE_RADIUS_M

SPEED_MPS = 0.5


def chapter(quick: bool) -> Chapter:
    """Return the section; it takes no time in either form."""
    turns = castor_table()
    by_angle, by_ratio, by_radius, *_ = turns
    L1_m = nearest_chassis_m()
    omega = SPEED_MPS / CIRCLE_RADIUS_M
    w1, w2 = wheel_speeds(Velocity(SPEED_MPS, omega), CHASSIS)
    lap_s = 2.0 * math.pi / omega
    return Chapter(
        number="3.1",
        title="Forward Kinematics Model of Robot",
        here={
            "wheel_radius_m": CHASSIS.r,
            "track_m": CHASSIS.L,
            "l1_m": CHASSIS.L1,
            "l2_m": CHASSIS.L2,
            "l3_m": CHASSIS.L3,
            "spin_radius_m": abs(turning_radius(-1.0, CHASSIS)),
            "castor_angle_deg": math.degrees(by_radius.beta_rad),
            "castor_radius_m": by_angle.radius_m,
            "castor_ratio": by_angle.ratio,
        },
        record={
            "turns": [turn._asdict() for turn in turns],
            "l1_that_would_fit_m": L1_m,
            "circle": {"omega_radps": omega, "w1_radps": w1, "w2_radps": w2, "lap_s": lap_s},
        },
        text=(
            "Equations 1 to 6 and 13 are implemented as printed, with two corrections to the "
            "text: wheel 1 is the right wheel, and L is the full track. With the labels in the "
            "text, w1 > w2 would turn the robot right, and a castor angle of 20 deg would give a "
            f"wheel ratio of {turns[-1].ratio:.2f} instead of about {PAPER_RATIO}.",
            "The three numbers of Figure 3 agree to a few percent, not exactly: 20 deg gives R = "
            f"{by_angle.radius_m:.3f} m and a ratio of {by_angle.ratio:.4f}; a ratio of "
            f"{PAPER_RATIO} gives {math.degrees(by_ratio.beta_rad):.2f} deg and "
            f"{by_ratio.radius_m:.3f} m; 1.17 m gives {math.degrees(by_radius.beta_rad):.2f} deg. "
            f"With an L1 of {1e3 * L1_m:.0f} mm instead of {1e3 * CHASSIS.L1:.0f} mm, 20 deg "
            "would give 1.17 m. The angle turned (90 deg) appears in none of the equations.",
            "The paper calls 1.17 m the minimum radius, but the same section says that the robot "
            "turns in place. The value is therefore read as the radius at which the castor "
            "reaches about 20 deg, not as a limit of the drive.",
            f"At {SPEED_MPS} m/s, the circle of section 5.2 requires a turn rate of {omega:.5f} "
            f"rad/s and wheel speeds of {w1:.4f} and {w2:.4f} rad/s. A lap takes {lap_s:.2f} s.",
        ),
        tables=(
            Table(
                "Castor angle, radius and wheel ratio, from each of the paper's three numbers",
                ("start from", "castor angle [deg]", "R [m]", "w1/w2"),
                [
                    (
                        turn.start,
                        f"{math.degrees(turn.beta_rad):.3f}",
                        f"{turn.radius_m:.4f}",
                        f"{turn.ratio:.4f}",
                    )
                    for turn in turns
                ],
            ),
        ),
        pictures=(
            Picture(
                "castor-turning",
                "Figure 3",
                "Turning radius and wheel ratio as a function of the castor angle, by equations "
                "5 and 6. The paper's point is 2 percent off the curve in radius.",
                plots.turning(turns),
            ),
            Picture(
                "castor-robot",
                "Figure 2",
                "The robot from above at a castor angle of 20 deg. The axles of all wheels meet "
                "at the center of the turn, as equation 6 requires.",
                plots.robot(by_angle),
            ),
        ),
    )
