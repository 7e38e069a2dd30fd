"""Proxemics: Hall's zones, and the depth of intrusion into personal space.

Source: E. T. Hall, The Hidden Dimension (1966), the distances that the paper builds its avoidance
interval on (section 3.2.1). Distances here are clearances, between surfaces: the nearest part of
the robot matters, not its centre.
"""

from __future__ import annotations

from hazbot_gym.core.geometry import clip
from hazbot_gym.core.jit import scalar

# Outer bound of each phase [m]: Hall's 6, 18, 30 inches, 4, 7, 12 and 25 feet, rounded as he does.
INTIMATE_NEAR_M, INTIMATE_M = 0.15, 0.45
PERSONAL_NEAR_M, PERSONAL_M = 0.75, 1.20
SOCIAL_NEAR_M, SOCIAL_M = 2.10, 3.60
PUBLIC_NEAR_M = 7.60

PHASE_BOUNDS_M = (
    INTIMATE_NEAR_M,
    INTIMATE_M,
    PERSONAL_NEAR_M,
    PERSONAL_M,
    SOCIAL_NEAR_M,
    SOCIAL_M,
    PUBLIC_NEAR_M,
)
PHASE_NAMES = tuple(
    f"{zone} {phase}"
    for zone in ("intimate", "personal", "social", "public")
    for phase in ("near", "far")
)


@scalar
def intrusion_depth(clearance_m: float) -> float:
    """Return the depth of intrusion into personal space: 0 from 1.2 m on, 1 from 0.45 m inward.

    Linear across the personal zone, for a continuous transition.
    """
    return clip((PERSONAL_M - clearance_m) / (PERSONAL_M - INTIMATE_M), 0.0, 1.0)
