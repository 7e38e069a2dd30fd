"""Sweep parameter of each family of rules, and its values.

A rule trades delay against discomfort, and its sweep parameter sets the trade-off. One value gives
one point; families are compared over all values.
"""

from __future__ import annotations

from typing import NamedTuple

from hazbot_gym.errors import InvalidInput


class Sweep(NamedTuple):
    """Sweep parameter: an option that moves a policy from assertive to cautious."""

    option: str
    values: tuple[float, ...]  # of a sweep, most assertive first


SWEEPS = {
    "constant": Sweep("fraction", (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1)),
    "stop_on_sight": Sweep("stop_m", (0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0)),
    "stop_when_near": Sweep("stop_m", (0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.9, 1.2, 1.5, 2.0)),
    "social_force": Sweep("strength", (0.1, 0.3, 0.6, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)),
    "ssm": Sweep("margin_m", (-0.5, -0.4, -0.3, -0.2, -0.1, 0.0, 0.2, 0.4, 0.7, 1.0, 1.5)),
    "ttc": Sweep("horizon_s", (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 20.0, 30.0)),
    "hall_steps": Sweep("scale", (0.3, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0)),
    "passive_safety": Sweep("obstacle_mps", (0.0, 0.8, 1.6, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)),
    "idm": Sweep("headway_s", (0.0, 0.5, 1.0, 1.6, 2.5, 4.0, 6.0, 8.0, 10.0, 12.0)),
    "velocity_obstacle": Sweep("margin_m", (0.0, 0.2, 0.45, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0)),
    "mpc": Sweep("caution", (0.0, 1.0, 2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 48.0)),
    "slow_on_rise": Sweep("rise_per_s", (0.4, 0.3, 0.2, 0.15, 0.12, 0.1, 0.08, 0.05, 0.02, 0.0)),
    "undo_lag": Sweep("level", (3.0, 2.0, 1.5, 1.2, 1.0, 0.8, 0.5, 0.3, 0.1, 0.0)),
    "fuzzy_expert": Sweep("scale", (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.15, 1.3, 1.5)),
}


def sweep(family: str) -> list[str]:
    """Return the policies of a family's sweep, as arguments of ``base.make``.

    Args:
        family: A name of ``SWEEPS``, with or without other options, such as
            ``ssm:mode=directional``.

    Raises:
        InvalidInput: The family has no sweep parameter, or the options already set it.
    """
    name, _, options = family.partition(":")
    if name not in SWEEPS:
        raise InvalidInput(f"sweep: given {family!r}, allowed are {', '.join(SWEEPS)}")
    option, values = SWEEPS[name]
    if option in (item.partition("=")[0].strip() for item in options.split(",")):
        raise InvalidInput(f"sweep: given {family!r}, but {option} is what the sweep sets")
    others = f"{options}," if options else ""
    return [f"{name}:{others}{option}={value:g}" for value in values]
