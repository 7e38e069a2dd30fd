from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.core.sensor_ring import SIX
from hazbot_gym.core.state import PATTERN_NAMES, Floats
from hazbot_gym.policies.sonar_estimate import CARRIED_S, STEADY_S, Echoes, listen, people
from hazbot_gym.task.observation import LAYOUTS

FRONT_LEFT, FRONT_RIGHT, LEFT, RIGHT = range(4)
WALL_M, AHEAD_M = 0.9, 2.245  # a corridor 2.4 m wide: beside the robot, and in the cones in front
NOBODY = ""


def seen(
    front_left: Any = AHEAD_M,
    front_right: Any = AHEAD_M,
    *,
    left: Any = WALL_M,
    right: Any = WALL_M,
    v: Any = 0.5,
    yaw_rate: float = 0.0,
    theta_e: float = 0.0,
) -> dict[str, Floats]:
    """Return a decoded observation of a robot in a corridor."""
    readings = np.broadcast_arrays(front_left, front_right, left, right, v, yaw_rate, theta_e)
    names = [f"range_{name}_m" for name in ("front_left", "front_right", "left", "right")]
    names += ["speed_mps", "yaw_rate_radps", "theta_e_rad"]
    return dict(zip(names, (np.array(r, np.float64) for r in readings), strict=True))


def hear(observations: Sequence[dict[str, Floats]], known: Echoes | None = None) -> Echoes:
    for observation in observations:
        known = listen(observation, known)
    assert known is not None
    return known


def found(known: Echoes, v: float = 0.5) -> dict[int, dict[str, float]]:
    """Return the fields of everybody present, by sensor; the pattern by its name."""
    fields = people(known, np.array(v))
    result = {}
    for k in np.flatnonzero(fields["present"]):
        one: dict[str, Any] = {name: float(values[k]) for name, values in fields.items()}
        one["pattern"] = "".join(name for name in PATTERN_NAMES if one[name])
        result[int(k)] = one
    return result


def coming(u: float, n: int, start_m: float = 2.1, v: float = 0.5) -> Floats:
    """Return n readings of somebody who comes at u while the robot drives at v."""
    return start_m - 0.1 * (u + v) * np.arange(n)


# --- who is there --------------------------------------------------------------------------------


def test_empty_corridor_holds_nobody_however_the_robot_is_turned() -> None:
    for theta_e in (-0.06, 0.0, 0.06):
        left_m = 0.5 * AHEAD_M / math.sin(math.radians(30) + theta_e)
        right_m = 0.5 * AHEAD_M / math.sin(math.radians(30) - theta_e)
        known = hear([seen(left_m, right_m, theta_e=theta_e)] * 30)
        assert found(known) == {}


def test_somebody_straight_ahead_is_heard_by_both_sensors_and_confronts_the_robot() -> None:
    known = hear([seen(r, r) for r in coming(1.0, 8)])
    person = found(known)[FRONT_LEFT]

    assert person["pattern"] == "confronting"
    assert person["speed_mps"] == pytest.approx(1.0, abs=0.12)
    assert person["closing_mps"] == pytest.approx(1.5, abs=0.12)
    assert person["distance_m"] == pytest.approx(2.1 - 0.1 * 1.5 * 7 + 0.5, abs=0.05)
    assert person["bearing_sin"] == 0.0
    assert person["closest_m"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("sensor", "sign"), [(FRONT_LEFT, 1), (FRONT_RIGHT, -1)])
def test_somebody_on_one_side_of_the_way_is_encountering(sensor: int, sign: int) -> None:
    one = [seen(r) if sensor == FRONT_LEFT else seen(AHEAD_M, r) for r in coming(1.0, 8)]
    only = found(hear(one))

    assert set(only) == {sensor}
    assert only[sensor]["pattern"] == "encountering"
    assert only[sensor]["bearing_sin"] == pytest.approx(sign * math.sin(math.radians(15)))
    assert only[sensor]["time_to_closest_s"] == pytest.approx(
        only[sensor]["distance_m"] / 1.5, rel=0.15
    )


def test_somebody_who_keeps_ahead_of_a_driving_robot_is_leading() -> None:
    known = hear([seen(r, r) for r in coming(-0.35, 15, start_m=1.8)])
    person = found(known)[FRONT_LEFT]

    assert person["pattern"] == "leading"
    assert person["speed_mps"] == pytest.approx(0.35, abs=0.08)
    assert person["closing_mps"] == pytest.approx(0.15, abs=0.08)


def test_what_stands_ahead_is_a_wall_until_it_is_nearer_than_any_wall() -> None:
    readings = coming(0.0, 30)  # 2.1 m to 0.65 m at the robot's own speed
    known, is_seen = None, []
    for r in readings:
        known = listen(seen(r, r), known)
        is_seen.append(bool(found(known)))

    assert is_seen == [bool(r < 0.9) for r in readings]
    assert known is not None
    assert found(known)[FRONT_LEFT]["pattern"] == "confronting"


def test_somebody_who_steps_in_from_the_side_is_crossing_until_it_has_stood_for_a_while() -> None:
    known = hear([seen(v=0.0)] * 5 + [seen(1.4, v=0.0)] * 5)
    assert found(known, 0.0)[FRONT_LEFT]["pattern"] == "crossing"

    known = hear([seen(1.4, v=0.0)] * round(STEADY_S / 0.1), known)
    assert found(known, 0.0) == {}


def test_walls_that_sweep_through_the_cones_in_a_turn_are_nobody() -> None:
    sweep = [seen(r, left=3.9, yaw_rate=0.5) for r in (2.2, 1.5, 1.4, 1.3, 1.2, 1.6, 1.2)]
    assert found(hear(sweep)) == {}


def test_somebody_beside_the_robot_is_nearer_than_the_wall() -> None:
    known = hear([seen()] * 5 + [seen(left=0.45)] * 4)
    person = found(known)[LEFT]

    assert person["pattern"] == NOBODY  # neither paper nor tracker has a pattern for it
    assert person["distance_m"] == pytest.approx(0.95, abs=0.05)
    assert person["bearing_sin"] == 1.0
    assert found(hear([seen()], known)).keys() <= {LEFT}  # carried on for a moment


def test_wall_beside_the_robot_is_what_kept_its_distance_and_an_opening_does_not_move_it() -> None:
    ahead_m = AHEAD_M - 0.8  # where the cone's edge meets a wall 0.4 m nearer
    known = hear([seen()] * 20 + [seen(AHEAD_M, ahead_m, right=0.5)] * 20)
    assert found(known) == {}
    assert known.side_wall_m[..., 1] == pytest.approx(0.5, abs=0.02)

    door = [
        seen(AHEAD_M, ahead_m, right=r)
        for r in (1.2, 2.0, 2.8, 2.8, 2.8, *([2.8] * 20), 2.0, 1.2, 0.5)
    ]
    assert found(hear(door, known)) == {}


# --- who is not heard any more -------------------------------------------------------------------


def test_who_leaves_the_cone_is_carried_on_until_it_would_have_passed() -> None:
    known = hear([seen(r) for r in coming(1.0, 9)])  # lost at 0.9 m, nearing at 1.5 m/s
    distances = []
    for _ in range(12):
        known = listen(seen(), known)
        distances.append(found(known).get(FRONT_LEFT, {}).get("distance_m"))

    there = [d for d in distances if d is not None]
    assert 4 <= len(there) <= 8  # 0.9 m / 1.5 m/s = 0.6 s
    assert distances[: len(there)] == there
    assert np.diff(there) == pytest.approx(-0.15, abs=0.02)


def test_nobody_is_carried_on_for_ever() -> None:
    known = hear([seen(r, r, v=0.0) for r in coming(-0.4, 12, start_m=1.2, v=0.0)])
    assert found(known, 0.0)
    known = hear([seen(v=0.0)] * round(CARRIED_S / 0.1 + 2), known)
    assert found(known, 0.0) == {}


# --- arrays, noise, and the world ----------------------------------------------------------------


def test_worlds_side_by_side_are_heard_as_each_alone_and_start_anew_alone() -> None:
    rng = np.random.default_rng(1)
    readings = rng.uniform(0.3, 4.0, (40, 4, 6)).cumsum(axis=0) / np.arange(1, 41)[:, None, None]
    starts = rng.random((40, 6)) < 0.1
    starts[0] = True
    together = None
    alone: list[Echoes | None] = [None] * 6
    for step, start in zip(readings, starts, strict=True):
        together = listen(seen(*step[:2], left=step[2], right=step[3]), together, start)
        for i in range(6):
            one = seen(*step[:2, i], left=step[2, i], right=step[3, i])
            alone[i] = listen(one, None if start[i] else alone[i])

    assert together is not None
    for name in Echoes._fields:
        expected = np.stack([getattr(one, name) for one in alone])
        assert np.array_equal(getattr(together, name), expected), name


def test_noise_of_the_paper_makes_nobody_out_of_a_wall_ahead() -> None:
    rng = np.random.default_rng(2)
    r = coming(0.0, 22)[:, None] + rng.uniform(-0.03, 0.03, (22, 500))
    known = hear([seen(row, AHEAD_M) for row in r])
    assert known.is_person.mean() < 0.01


# --- two more sensors ----------------------------------------------------------------------------

DIAGONAL_M = (1.2 - 0.3 * math.sin(math.radians(52.5))) / math.sin(math.radians(67.5))  # the wall


def seen_by_six(left: float = DIAGONAL_M, right: float = DIAGONAL_M) -> dict[str, Floats]:
    """Return the observation of an empty corridor but for the diagonal sensors."""
    more = {"range_diagonal_left_m": np.array(left), "range_diagonal_right_m": np.array(right)}
    return {**seen(), **more}


def heard_by_six(left_m: Sequence[float]) -> Floats:
    """Return the bearings of people estimated from a diagonal sensor's readings [rad]."""
    known = None
    for reading_m in left_m:
        known = listen(seen_by_six(reading_m), known, ring=SIX)
    assert known is not None
    fields = people(known, np.array(0.5), SIX)
    is_there = fields["present"] > 0.5
    return np.arctan2(fields["bearing_sin"], fields["bearing_cos"])[is_there]


def test_six_sensors_hear_nobody_in_an_empty_corridor() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        readings_m = DIAGONAL_M + rng.uniform(-0.03, 0.03, 30)
        assert heard_by_six(readings_m.tolist()).tolist() == []


def test_somebody_in_front_of_the_wall_is_found_by_a_diagonal_sensor() -> None:
    standing = [DIAGONAL_M] * 10 + [0.5]
    assert heard_by_six(standing) == pytest.approx([math.radians(52.5)])


def test_people_of_the_reference_world_are_found_where_the_cones_reach() -> None:
    sonar, truth = LAYOUTS["sonar"], LAYOUTS["privileged"]
    options: dict[str, Any] = {"tier": "privileged", "people": {"count": [3, 5]}}
    env = gymnasium.make("hazbot_gym/Corridor-v1", **options)
    errors, hits, alarms = [], [], []
    for seed in range(6):
        observation, _ = env.reset(seed=seed)
        known, done = None, False
        while not done:
            told, true = sonar.decode(observation[: sonar.width]), truth.decode(observation)
            known = listen(told, known)
            fields = people(known, told["speed_mps"])
            distances = np.where(fields["present"] > 0.5, fields["distance_m"], np.inf)
            k = int(distances.argmin())
            is_there = true["person0_present"] > 0.5
            if is_there and true["person0_bearing_cos"] > 0.94 and true["person0_distance_m"] < 2.0:
                hits.append(abs(distances[k] - true["person0_distance_m"]) < 0.4)
                if hits[-1]:
                    errors.append(abs(fields["closing_mps"][k] - true["person0_closing_mps"]))
            elif not is_there or true["person0_distance_m"] > 3.2:
                alarms.append(np.isfinite(distances[k]))
            observation, _, terminated, truncated, _ = env.step(np.array([0.2], np.float32))
            done = terminated or truncated

    assert len(hits) > 100
    assert np.mean(hits) > 0.9
    assert np.median(errors) < 0.12
    assert len(alarms) > 100
    assert np.mean(alarms) < 0.15  # most of them people who are carried on
