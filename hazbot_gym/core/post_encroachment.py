"""Post-encroachment time of a robot and a person on crossing paths (Allen, Shin, Cooper 1978)."""

from __future__ import annotations

import math

from hazbot_gym.core.jit import kernel
from hazbot_gym.core.state import Floats

ACROSS = 0.7  # |sin| of the angle between two ways from which on they cross: 45 degrees


@kernel
def post_encroachment_time(
    time_s: Floats, pose: Floats, person_time_s: Floats, person: Floats, reach: float
) -> float:
    """Return the post-encroachment time [s]: from leaving to reaching a shared place, at least.

    ``min |t - t'|`` over the instants at which ``|p(t) - q(t')| < reach`` and the ways cross:
    ``|sin| >= 0.7`` of the angle between the robot's heading and the person's velocity. Infinite if
    there are none.

    Args:
        time_s: (T,) instants of the robot.
        pose: (T, 3) its x, y [m] and heading [rad].
        person_time_s: (S,) instants of the person.
        person: (S, 4) its x, y [m] and velocity [m/s].
        reach: Sum of the radii [m].
    """
    least = math.inf
    for i in range(len(time_s)):
        x, y, heading = pose[i]
        cosine, sine = math.cos(heading), math.sin(heading)
        for j in range(len(person_time_s)):
            apart = abs(time_s[i] - person_time_s[j])
            if apart >= least:
                continue
            px, py, vx, vy = person[j]
            meets = (x - px) ** 2 + (y - py) ** 2 < reach**2
            if meets and abs(cosine * vy - sine * vx) >= ACROSS * math.hypot(vx, vy):
                least = apart
    return least
