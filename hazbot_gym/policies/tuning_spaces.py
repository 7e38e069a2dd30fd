"""Tuning spaces of the rule families, with bounds around every default.

The bounds are wide enough that all best validation results so far lie inside. The record of a
search reports options at a bound.
"""

from __future__ import annotations

from typing import NamedTuple, get_args

from hazbot_gym.policies.gas_rule import PeopleRules


class Interval(NamedTuple):
    """Closed interval of a tunable number."""

    low: float
    high: float


Choice = tuple[str, ...]
Space = dict[str, Interval | Choice]

_PEOPLE = get_args(PeopleRules)

SPACES: dict[str, Space] = {
    "constant": {"fraction": Interval(0.05, 1.0)},
    "stop_on_sight": {"stop_m": Interval(0.2, 2.5)},
    "stop_when_near": {"stop_m": Interval(0.0, 2.5)},
    "ssm": {"mode": ("strict", "directional"), "margin_m": Interval(-0.55, 2.0)},
    "ttc": {"horizon_s": Interval(0.0, 30.0), "margin_m": Interval(0.0, 1.5)},
    "hall_steps": {"scale": Interval(0.2, 5.0)},
    "passive_safety": {"obstacle_mps": Interval(0.0, 10.0)},
    "idm": {"headway_s": Interval(0.0, 15.0)},
    "velocity_obstacle": {"margin_m": Interval(0.0, 2.5)},
    "mpc": {"caution": Interval(0.0, 100.0)},
    "social_force": {"strength": Interval(0.0, 100.0)},
    "slow_on_rise": {
        "rise_per_s": Interval(-0.1, 1.0),
        "slow": Interval(0.0, 1.0),
        "people": _PEOPLE,
    },
    "undo_lag": {
        "level": Interval(-1.0, 5.0),
        "slow": Interval(0.0, 1.0),
        "lag_s": Interval(0.0, 20.0),
        "people": _PEOPLE,
    },
    "fuzzy_expert": {
        "scale": Interval(0.3, 2.0),
        "t_norm": ("min", "product"),
        "pattern": ("crisp", "gaussian"),
        "release": ("false", "true"),
        "horizon_s": Interval(0.0, 2.0),
    },
}
