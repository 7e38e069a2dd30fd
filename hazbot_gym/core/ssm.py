"""Speed and separation monitoring (SSM, ISO/TS 15066): protective separation distance.

Constant braking a is assumed. Formula after Marvel and Norcross (2017), Implementing speed and
separation monitoring in collaborative robot workcells. Left out: the difference between the
standard's separate uncertainties of robot and person.
"""

from __future__ import annotations

import hashlib
from typing import Annotated, NamedTuple

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Gt

from hazbot_gym.core.state import Floats


class SsmThresholds(NamedTuple):
    """Parameters of the protective separation distance; numbers of two profiles never mix."""

    braking_mps2: Annotated[float, Gt(0)] = 1.0  # a, the drive's own slew limit
    reaction_s: Annotated[float, Ge(0)] = 0.1  # T_r, one decision period
    intrusion_m: Annotated[float, Ge(0)] = 0.45  # C, Hall's intimate zone
    uncertainty_m: Annotated[float, Ge(0)] = 0.1  # Z, position of robot and person together
    approach_mps: Annotated[float, Ge(0)] = 1.6  # v_h, walking speed of ISO 13855 if not measured

    def profile(self) -> str:
        """Return a short signature of these numbers, stored with every row measured by them."""
        text = ",".join(f"{name}={value!r}" for name, value in self._asdict().items())
        return hashlib.sha256(text.encode()).hexdigest()[:12]


def protective_distance(v: Floats, ssm: SsmThresholds) -> Floats:
    """Return the separation S_p [m] below which a robot at speed v should not be moving.

    ``S_p = v_h (T_r + v/a) + v T_r + v^2 / (2 a) + C + Z``
    """
    a, t_r, v_h = ssm.braking_mps2, ssm.reaction_s, ssm.approach_mps
    stopping = v * t_r + v**2 / (2 * a)
    return v_h * (t_r + v / a) + stopping + ssm.intrusion_m + ssm.uncertainty_m


def permitted_speed(
    c: npt.ArrayLike, ssm: SsmThresholds, approach_mps: npt.ArrayLike | None = None
) -> Floats:
    """Return the largest speed v at which S_p(v) <= c: the inverse of ``protective_distance``.

    ``v = -(a T_r + v_h) + sqrt((a T_r + v_h)^2 + 2 a (c - v_h T_r - C - Z))``, 0 where S_p(0) > c.

    Args:
        c: Clearances, surface to surface, any shape [m].
        ssm: Parameters.
        approach_mps: v_h if measured, of the same shape; the parameters' value if None.
    """
    a, t_r = ssm.braking_mps2, ssm.reaction_s
    v_h = np.asarray(ssm.approach_mps if approach_mps is None else approach_mps, dtype=np.float64)
    spare_m = np.asarray(c) - v_h * t_r - ssm.intrusion_m - ssm.uncertainty_m
    b = a * t_r + v_h
    return np.where(spare_m > 0.0, np.sqrt(b**2 + 2.0 * a * np.maximum(spare_m, 0.0)) - b, 0.0)
