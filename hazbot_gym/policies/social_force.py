"""Social force as a speed policy: the total force along the path gives the acceleration.

Paper eqs 7 and 8a: ``m dv/dt = F_acc + F_int + F_att``. The paper gives neither force law nor
constants. This policy uses those of Helbing and Molnar 1995 (``core/social_force.py``), as
published, with the robot as a walker whose desired velocity is the nominal speed along its path:

    dv/dt = (v_nom - v)/tau + sum_b w(e, f_b) f_b . e,    f_b = A exp(-c_b/B) n_b
    v <- clip(v + dv/dt dt, 0, v_nom)

with the clearance c_b to person b and the unit vector n_b from person b to the robot. The forces
are per unit mass, so the robot's 34 kg cancel: F = 34 kg times the acceleration. F_acc is the first
term, F_int the sum; the attraction of the goal, F_att, is part of the first term. Not modeled: the
elliptical form, whose two terms cancel on the line of sight as soon as the person's step reaches
the robot; walls, since the path keeps clear of walls; and steering.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt
from pydantic.dataclasses import dataclass

from hazbot_gym.core.elementary import decay
from hazbot_gym.core.geometry import clip
from hazbot_gym.core.jit import lean_kernel
from hazbot_gym.core.social_force import HELBING_MOLNAR_1995, SocialForce, goal_force, view_weight
from hazbot_gym.core.state import (
    Floats,
    Records,
    as_record,
)
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.people_seen import RADII_M
from hazbot_gym.policies.person_columns import Columns, columns_of
from hazbot_gym.policies.robot import DECISION_S, NOMINAL_MPS
from hazbot_gym.task.observation import layout_of

PERSON_FIELDS = ("present", "distance_m", "bearing_cos", "bearing_sin")


@dataclass(frozen=True, config=OPTIONS)
class SocialForceSpeed(PeopleRule):
    """Accelerates by the total social force along the robot's heading."""

    strength: Annotated[float, Ge(0)] = 1.0  # factor of the repulsion; the sweep parameter
    nominal_mps: Annotated[float, Gt(0)] = NOMINAL_MPS  # speed of action +1

    def speed_share(self, observation: Observations) -> Observations:
        """Return the share of the nominal speed a decision later; see ``base.Rule``."""
        rows = np.atleast_2d(np.ascontiguousarray(observation, np.float32))
        share = np.empty(len(rows), np.float32)
        columns = columns_of(layout_of(rows), PERSON_FIELDS)
        how = np.array([self.strength, self.nominal_mps, DECISION_S])
        _answer(rows, columns, as_record(HELBING_MOLNAR_1995), how, share)
        return share.reshape(np.shape(observation)[:-1])


@lean_kernel
def _answer(
    rows: Observations, columns: Columns, constants: Records, how: Floats, out: Observations
) -> None:
    """Write the share of the nominal speed for each observation: (N, n) to (N,).

    ``how`` holds strength, nominal speed [m/s] and decision period [s].
    """
    force: SocialForce = constants[0]
    index, units = columns.entries, columns.units
    for i in range(rows.shape[0]):
        row = rows[i]
        v = row[columns.own[0]] * columns.own_units[0]
        acceleration = goal_force(v, 0.0, 1.0, 0.0, how[1], force.relaxation_time_s)[0]
        for k in range(index.shape[0]):
            if row[index[k, 0]] * units[k, 0] < 0.5:
                continue
            # n points from the person to the robot, in the robot's frame.
            nx = -row[index[k, 2]] * units[k, 2]
            ny = -row[index[k, 3]] * units[k, 3]
            clearance_m = max(row[index[k, 1]] * units[k, 1] - RADII_M, 0.0)
            f = how[0] * force.robot_strength_mps2 * decay(-clearance_m / force.robot_range_m)
            acceleration += view_weight(1.0, 0.0, f * nx, f * ny, force) * f * nx
        out[i] = clip((v + acceleration * how[2]) / how[1], 0.0, 1.0)
