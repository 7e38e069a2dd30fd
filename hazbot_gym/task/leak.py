"""Leak of an episode: whether there is one, where, how strong, and in which draught."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from hazbot_gym.config import Config, Gas
from hazbot_gym.core.gas_sensor import clear_smell, gas_sensor_of, nose_of
from hazbot_gym.core.geometry import path_length, sample_path
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.noise import LEAK_DRAW, uniform4
from hazbot_gym.core.state import GAS, Floats, GasRecord, Place, Records, as_record, records

END_M = 1.0  # leaks keep this distance from both ends of the path
OPEN_M = 2.0  # lateral range of leaks where there is no wall
SAMPLES = 33  # points of the path at which the distance to the walls is taken


class LeakRules(NamedTuple):
    """Distribution of leaks: uniform position, log-uniform strength, uniform draught."""

    share: float  # of episodes with a leak
    weakest_ppm: float
    strongest_ppm: float
    slowest_mps: float
    fastest_mps: float


class GasTable(NamedTuple):
    """Parameters of gas, as arrays for kernels; records (0,) without gas."""

    rules: Records  # (1,) LeakRules
    plume: Records  # (1,) Plume
    nose: Records  # (1,) Nose
    sides: Floats  # (places, 2) distance from the path to the walls on the left and right [m]


def gas_table(config: Config, places: list[Place]) -> GasTable:
    """Return the parameters of a config's gas."""
    gas, some = (Gas(), 0) if config.gas is None else (config.gas, 1)
    rules = LeakRules(gas.leak_share, *gas.strength_ppm, *gas.draught_mps)
    sensor = gas_sensor_of(gas.sensor)
    return GasTable(
        rules=as_record(rules)[:some],
        plume=as_record(gas.plume)[:some],
        nose=as_record(nose_of(sensor, config.clock.decision_s))[:some],
        sides=np.array([sides_of(place) for place in places if some]).reshape(-1, 2),
    )


def sides_of(place: Place) -> tuple[float, float]:
    """Return the median distance from the path to the walls on its left and right [m]."""
    length = path_length(place.path.view(np.recarray))
    poses = sample_path(place.path, np.linspace(0.0, length, SAMPLES))
    beside = [_walls_beside(x, y, heading, place.walls) for x, y, heading, *_ in poses]
    left, right = np.median(beside, axis=0)
    return float(left), float(right)


def _walls_beside(x: float, y: float, heading: float, walls: Floats) -> tuple[float, float]:
    """Return the distance to the nearest wall along the normal of a pose, left and right [m]."""
    nearest = [math.inf, math.inf]
    ahead = np.array([math.cos(heading), math.sin(heading)])
    for x1, y1, x2, y2 in walls:
        (a1, n1), (a2, n2) = (
            (ahead @ d, ahead[0] * d[1] - ahead[1] * d[0])
            for d in (np.array([x1 - x, y1 - y]), np.array([x2 - x, y2 - y]))
        )
        if a1 * a2 > 0.0 or a1 == a2:
            continue
        normal = n1 + (n2 - n1) * a1 / (a1 - a2)
        side = 0 if normal > 0.0 else 1
        nearest[side] = min(nearest[side], abs(normal))
    return nearest[0], nearest[1]


@scalar
def clear_gas(gas: GasRecord) -> None:
    """Reset an episode's gas: no leak, clean air, nothing reported."""
    leak = gas.leak
    leak.is_there = 0
    leak.s_m = leak.y_m = leak.strength_ppm = leak.draught_mps = 0.0
    leak.left_m = leak.right_m = leak.phase_1 = leak.phase_2 = leak.phase_3 = 0.0
    clear_smell(gas.smell)
    gas.is_reported = gas.false_alarms = 0


@scalar
def draw_leak(
    gas: GasRecord, rules: LeakRules, length_m: float, left_m: float, right_m: float, key: np.uint64
) -> None:
    """Write the leak of a scenario; the record must be clear before."""
    u1, u2, u3, u4 = uniform4(key, LEAK_DRAW, 0, 0)
    w1, w2, w3, w4 = uniform4(key, LEAK_DRAW, 0, 1)
    leak = gas.leak
    if u1 >= rules.share:
        return
    leak.is_there = 1
    leak.s_m = END_M + max(length_m - 2.0 * END_M, 0.0) * u2
    leak.left_m, leak.right_m = left_m, right_m
    lowest_m, highest_m = -min(right_m, OPEN_M), min(left_m, OPEN_M)
    leak.y_m = lowest_m + (highest_m - lowest_m) * u3
    leak.strength_ppm = rules.weakest_ppm * (rules.strongest_ppm / rules.weakest_ppm) ** u4
    speed_mps = rules.slowest_mps + (rules.fastest_mps - rules.slowest_mps) * abs(2.0 * w1 - 1.0)
    leak.draught_mps = speed_mps if w1 < 0.5 else -speed_mps
    leak.phase_1, leak.phase_2 = 2.0 * math.pi * w2, 2.0 * math.pi * w3
    leak.phase_3 = 2.0 * math.pi * w4


@lean_kernel
def _draw(
    gases: Records, rules: Records, length_m: float, left_m: float, right_m: float, key: np.uint64
) -> None:
    draw_leak(gases[0], rules[0], length_m, left_m, right_m, np.uint64(key))


def leak_of(table: GasTable, place: int, path: Records, key: int) -> Records:
    """Return the gas record (1,) at the start of an episode, (0,) without gas."""
    gas = records(GAS, len(table.rules))
    if len(gas):
        length_m = path_length(path.view(np.recarray))
        left_m, right_m = table.sides[place]
        _draw(gas, table.rules, length_m, left_m, right_m, np.uint64(key))
    return gas


def leak_point(place: Place, gas: Records) -> Floats:
    """Return the position (2,) of the leak of a record (1,) [m], (0,) without one."""
    leaks = gas["leak"][gas["leak"]["is_there"] == 1]
    x, y, heading, _ = sample_path(place.path, leaks["s_m"]).T
    aside = leaks["y_m"]
    return np.concatenate([x - aside * np.sin(heading), y + aside * np.cos(heading)])


def gas_info(gas: Records) -> dict[str, Any]:
    """Return the gas in infos, by name, arrays (N,); 0 for a leak that is not there."""
    leak, smell = gas["leak"], gas["smell"]
    is_there = leak["is_there"].copy()
    return {
        "concentration_ppm": smell["concentration_ppm"].copy(),
        "reading": smell["reading"].copy(),
        "alarm": smell["alarm"].copy(),
        "leak": is_there,
        "leak_s_m": leak["s_m"].copy(),
        "leak_distance_m": np.where(is_there == 1, leak["s_m"] - smell["s_m"], 0.0),
        "reported": gas["is_reported"].copy(),
        "false_alarms": gas["false_alarms"].copy(),
    }
