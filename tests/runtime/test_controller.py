from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym import SpeedController, make_policy
from hazbot_gym.evaluation.driver import driver_of
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import describe, write
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.lstm import Lstm
from hazbot_gym.runtime.people import Person
from hazbot_gym.runtime.readings import Readings
from hazbot_gym.runtime.robot_file import Robot
from hazbot_gym.task.observation import TRACKER_RANGE_M
from tests.refusals import refused

GOOD: dict[str, Any] = {
    "ranges_m": [4.0, 4.0, 1.1, 1.2],
    "speed_mps": 0.4,
    "yaw_rate_radps": 0.0,
    "x_e_m": 0.0,
    "y_e_m": 0.0,
    "theta_e_rad": 0.0,
    "remaining_m": 8.0,
    "curvature_ahead_per_m": 0.0,
    "people": [],
}


class Clock:
    """A clock that is set by hand."""

    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


class Fixed:
    """A policy that always gives the same action, and counts its calls in its state."""

    def __init__(self, action: object) -> None:
        self.action = action

    def predict(self, observation: Any, state: Any = None, **_: Any) -> tuple[Any, Any]:
        return np.array([self.action]), (state or 0) + 1


def controlled(policy: Any, **options: Any) -> SpeedController:
    """Return a controller whose clock stands still."""
    return SpeedController(policy, **{"clock": Clock(), **options})


def a_file(folder: Path, *, tier: str = "sonar", lstm: bool = False, **about: Any) -> Path:
    """Write a small random actor, and return its path."""
    rng = np.random.default_rng(0)
    width = {"sonar": 12, "tracks": 51}[tier]

    def layer(inputs: int, outputs: int) -> Layer:
        weight = rng.normal(size=(inputs, outputs)).astype(np.float32)
        return Layer(weight, np.zeros(outputs, np.float32))

    memory = Lstm(layer(width + 3, 12)) if lstm else None
    sizes = (3 if lstm else width, 5, 1)
    layers = tuple(layer(*pair) for pair in itertools.pairwise(sizes))
    file = folder / "policy.npz"
    with file.open("wb") as opened:
        write(describe(Actor(layers, "tanh", "clipped", lstm=memory),
                       algorithm="PPO", tier=tier, **about), opened)  # fmt: skip
    return file


def people_seen(env: Any) -> list[Person]:
    """Return the people that a simulated tracker reports, in the robot's frame."""
    robot, found = env._world.robots[0], []
    cosine, sine = math.cos(robot["theta"]), math.sin(robot["theta"])

    def turned(x: float, y: float) -> tuple[float, float]:
        return cosine * x + sine * y, cosine * y - sine * x

    for i, track in enumerate(env._tracks):
        if track["visible"]:
            place = turned(track["x"] - robot["x"], track["y"] - robot["y"])
            found.append(Person(*place, *turned(track["vx"], track["vy"]), track=i))
    return found


@pytest.mark.parametrize(("policy", "slots"), [("fuzzy_expert", 3), ("ppo", 3), ("ppo", 5)])
def test_speeds_are_those_of_the_simulator_through_an_episode(policy: str, slots: int) -> None:
    values = {"max_episode_steps": 150, "person_slots": slots}
    env = gymnasium.make("hazbot_gym/Encountering-v1", **values).unwrapped
    controller = controlled(policy, dead_band_mps=0.0, person_slots=slots)
    asked = driver_of(make_policy(policy), env.config)
    observation, _ = env.reset(seed=3)
    met = compared = 0
    for _ in range(150):
        seen = {name: float(value) for name, value in controller.layout.decode(observation).items()}
        people = people_seen(env)
        given = {name: seen[name] for name in GOOD if name in seen}
        ranges = [seen[f"range_{each.name}_m"] for each in controller.layout.sensors]
        speed_mps = controller.step(ranges_m=ranges, people=people, **given)
        action, _ = asked.predict(observation)

        assert controller.stop is None
        # The simulated tracker sees whoever is within its range, and reports a noisy place, which
        # may lie beyond; the controller leaves out whoever is reported there.
        if all(math.hypot(one.x_m, one.y_m) <= TRACKER_RANGE_M for one in people):
            assert speed_mps == pytest.approx(0.25 * (float(action[0]) + 1.0), abs=1e-5)
            compared += 1
        met += int(seen["person0_crossing"] + seen["person0_encountering"])
        observation, *_ = env.step(np.float32([4.0 * speed_mps - 1.0]))
    assert met > 10
    assert compared > 140


@pytest.mark.parametrize(
    ("policy", "tier"),
    [
        ("ppo", "sonar"),
        ("ssm:mode=directional", "sonar"),
        ("mpc", "tracks"),
        ("stop_on_sight", "sonar"),
        ("constant:fraction=0.5", "sonar"),
    ],
)
def test_rules_and_shipped_policies_answer_as_predict_does(policy: str, tier: str) -> None:
    controller, asked = controlled(policy, tier=tier, dead_band_mps=0.0), make_policy(policy)
    state, command_mps = None, 0.0
    for k in range(30):
        ranges = [4.0 - 0.1 * k, 4.0, 1.1, 1.2]
        people = [Person(4.0 - 0.1 * k, 0.2, -1.0, 0.0)]
        fields = {name: GOOD[name] for name in GOOD if name not in ("ranges_m", "people")}
        readings = Readings(tuple(ranges), fields | {"command_mps": command_mps}, people)
        action, state = asked.predict(controller.observation(readings), state)
        command_mps = controller.step(**{**GOOD, "ranges_m": ranges, "people": people})
        assert command_mps == pytest.approx(0.25 * (float(action[0]) + 1.0), abs=1e-7)


@pytest.mark.parametrize("lstm", [False, True])
def test_a_trained_file_keeps_its_memory_until_the_reset(tmp_path: Path, lstm: bool) -> None:
    controller = controlled(f"learned:path={a_file(tmp_path, lstm=lstm)}", tier="sonar")
    first, second = controller.step(**GOOD), controller.step(**GOOD, command_mps=0.0)
    controller.reset()

    assert controller.stop is not None
    assert controller.stop.cause == "no readings"
    assert controller.step(**GOOD) == first
    assert (second == first) is not lstm


def test_a_residual_policy_has_its_base(tmp_path: Path) -> None:
    residual = {"base": "constant:fraction=0.5", "scale": 0.1}
    file = a_file(tmp_path, residual=residual)
    controller = controlled(f"learned:path={file}", tier="sonar")
    assert 0.225 <= controller.step(**GOOD) <= 0.275


@pytest.mark.parametrize(
    ("readings", "cause"),
    [
        ({"speed_mps": None}, "missing"),
        ({"ranges_m": [math.nan] * 4}, "not finite"),
        ({"yaw_rate_radps": 100.0}, "impossible"),
        ({"age_s": 0.31}, "stale"),
        ({"age_s": math.nan}, "stale"),
        ({"age_s": None}, "stale"),
        ({"age_s": -1.0}, "stale"),
    ],
)
def test_unusable_readings_stop_the_robot_and_good_ones_start_it_again(
    readings: dict[str, Any], cause: str
) -> None:
    controller = controlled(Fixed(1.0))
    assert controller.step(**GOOD) == 0.5
    assert controller.step(**{**GOOD, **readings}) == 0.0
    assert controller.stop is not None
    assert controller.stop.cause == cause
    assert controller.current_mps() == 0.0
    assert controller.step(**GOOD) == 0.5
    assert controller.stop is None


def test_without_steps_the_command_falls_to_nothing() -> None:
    clock = Clock()
    controller = controlled(Fixed(1.0), clock=clock)
    assert controller.current_mps() == 0.0
    controller.step(**GOOD)
    clock.now_s += 0.29
    assert controller.current_mps() == 0.5
    clock.now_s += 0.02
    assert controller.current_mps() == 0.0
    assert controller.stop is not None
    assert controller.stop.cause == "stale"


def test_a_gap_between_steps_stops_once_and_ends_the_policy_s_memory() -> None:
    clock = Clock()
    controller = controlled(Fixed(1.0), clock=clock)
    for gap_s, expected_mps in ((0.1, 0.5), (0.1, 0.5), (0.5, 0.0), (0.1, 0.5)):
        clock.now_s += gap_s
        assert controller.step(**GOOD) == expected_mps
    assert controller._state == 1


@pytest.mark.parametrize(
    ("action", "expected_mps"), [(-0.97, 0.0), (-0.95, 0.0125), (1, 0.125), (4, 0.5)]
)
def test_slow_commands_are_standing_and_whole_numbers_are_levels(
    action: float, expected_mps: float
) -> None:
    controller = controlled(Fixed(action))
    assert controller.step(**GOOD) == pytest.approx(expected_mps)


@pytest.mark.parametrize("action", [math.nan, 1.1, -2.0])
def test_an_action_out_of_bounds_stops_the_robot(action: float) -> None:
    controller = controlled(Fixed(action))
    assert controller.step(**GOOD) == 0.0
    assert controller.stop is not None
    assert controller.stop.cause == "policy"


def test_the_last_command_is_observed_or_the_one_that_is_given() -> None:
    class Echo:
        def predict(self, observation: Any, state: Any = None, **_: Any) -> tuple[Any, Any]:
            seen.append(float(observation[6]))
            return np.array([0.0]), None

    seen: list[float] = []
    controller = controlled(Echo())
    seen.clear()
    controller.step(**GOOD)
    controller.step(**GOOD)
    controller.step(**GOOD, command_mps=0.125)
    assert seen == [0.0, 0.25, 0.125]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"policy": "telepathy"}, "telepathy"),
        ({"policy": "ppo", "tier": "radar"}, "radar ... sonar"),
        ({"policy": "ppo", "ring": "six"}, "6 range sensors ... ppo"),
        ({"policy": "slow_on_rise"}, "gas"),
        ({"policy": "ppo", "stale_s": 0.0}, "stale_s ... 0"),
        ({"policy": "ppo", "robot": Robot(nominal_speed_mps=0.8)}, "0.8 ... ppo ... 0.5"),
        ({"policy": "ppo", "robot": "nowhere.yaml"}, "nowhere.yaml"),
    ],
)
def test_what_does_not_fit_is_refused_when_the_controller_is_made(
    arguments: dict[str, Any], said: str
) -> None:
    with refused(said):
        controlled(**arguments)


def test_a_policy_is_checked_against_the_robot_of_its_training(tmp_path: Path) -> None:
    config = {
        "drive": {"nominal_speed_mps": 0.8, "deceleration_mps2": 1.5},
        "clock": {"decision_s": 0.2},
        "sensors": {"ring": "paper", "ultrasonic": [4.0, 0.26, 0.25]},
    }
    file = a_file(tmp_path, training={"environments": {"mine": config}})
    controller = controlled(f"learned:path={file}", tier="sonar")

    assert controller.robot.nominal_speed_mps == 0.8
    assert controller.robot.sensors[2].y_m == 0.25
    with refused("nominal_speed_mps ... 0.5 ... 0.8"):
        controlled(f"learned:path={file}", tier="sonar", robot=Robot())


def test_rules_with_another_nominal_speed_command_it() -> None:
    controller = controlled("ssm:mode=strict,nominal_mps=0.3")
    assert controller.robot.nominal_speed_mps == 0.3


def test_gas_is_read_where_there_is_a_sensor() -> None:
    controller = controlled("slow_on_rise", tier="sonar", has_gas=True)
    gas: dict[str, Any] = {"gas_reading": 0.5, "gas_since_peak_s": 0.0, "gas_alarmed": 0.0}
    assert controller.step(**GOOD, **gas, gas_rate_per_s=0.0) == 0.0
    assert controller.stop is not None
    assert "gas_reading_1s" in controller.stop.message
    gas["gas_history"] = [0.4] * 10
    assert controller.step(**GOOD, **gas, gas_rate_per_s=0.0) == 0.5
    assert controller.step(**GOOD, **gas, gas_rate_per_s=1.0) == pytest.approx(0.1)
