from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from pydantic import ValidationError

from hazbot_gym.config import SCENARIOS, Clock, Config, Gas, make_config
from hazbot_gym.core.pid import PLANTS
from tests.refusals import refused

NAN, INF = math.nan, math.inf
SENSOR = {"rise_s": 1.0, "decay_s": 4.0, "half_ppm": 5.0, "exponent": 0.5}
WALKER = {"x_m": 1.0, "y_m": 1.0, "vx_mps": 0.0, "vy_mps": 0.0}


def ring(**angles_rad: float) -> list[dict[str, Any]]:
    return [{"name": name, "angle_rad": angle} for name, angle in angles_rad.items()]


def test_nothing_given_is_the_default() -> None:
    assert make_config() == make_config({}) == make_config(Config()) == Config()


@pytest.mark.parametrize(
    ("text", "has_gas"),
    [("tier: sonar", False), ("gas:", False), ("gas: null", False), ("gas: {}", True)],
)
def test_gas_is_on_where_its_section_is_given_even_if_empty(
    text: str, has_gas: bool, tmp_path: Path
) -> None:
    file = tmp_path / "config.yaml"
    file.write_text(text)
    assert make_config(file).gas == (Gas() if has_gas else None)


@pytest.mark.parametrize(
    ("overrides", "complaint"),
    [
        ({"plcae": "open"}, "plcae ... unknown ... place, place_options, tracks"),
        ({"tier": "x-ray"}, "tier ... 'x-ray' ... 'sonar', 'tracks'"),
        ({"max_episode_steps": 0}, "max_episode_steps ... 0 ... greater than 0"),
        ({"people": None}, "people ... None ... dictionary"),
        ({"place": 3}, "place ... 3 ... string"),
        ({"place_options": {"width_m": "wide"}}, "place_options.width_m ... 'wide'"),
        ({"place_options": {"width_m": NAN}}, "place_options.width_m ... nan"),
        ({"drive": {"nominal_speed_mps": NAN}}, "drive.nominal_speed_mps ... nan"),
        ({"drive": {"acceleration_mps2": INF}}, "drive.acceleration_mps2 ... inf"),
        ({"drive": {"plant": "Z"}}, "drive.plant ... 'Z' ... 'A', 'B', 'A0'"),
        ({"drive": {"plant": {"K": -1.0}}}, "drive.plant.K ... -1.0"),
        ({"drive": {"plant": {"k": 1.0}}}, "drive.plant.k ... unknown ... K, T1, T2"),
        ({"scenario": "circle", "drive": {"plant": {"T1": 3.0}}}, "plant ... 'B'"),
        (
            {"reward": [1]},
            "reward ... [1] ... 8 ... progress",
        ),
        ({"drive": {"plant": [1, 2]}}, "plant ... [1, 2] ... 6 ... K, T1, T2"),
        ({"sensors": {"tracker": []}}, "tracker ... [] ... 6 ... range_m"),
        (
            {"people": {"reactions": [[1.0]] * 4}},
            "reactions.0 ... [1.0] ... gain",
        ),
        ({"drive": {"chassis": {"r": NAN}}}, "drive.chassis.r ... nan"),
        ({"drive": {"tracking": {"a4": 1.0}}}, "drive.tracking.a4 ... unknown ... a1"),
        ({"drive": {"start_speed_mps": 0.6}}, "start_speed_mps = 0.6 ... nominal"),
        ({"people": {"family": "waltz"}}, "people.family ... 'waltz' ... 'mixed'"),
        ({"people": {"count": (3, 1)}}, "count ... (3, 1)"),
        ({"people": {"count": (0, 65)}}, "people.count.1 ... 65 ... less"),
        ({"people": {"count": 3}}, "people.count ... 3 ... tuple"),
        ({"people": {"mix": (0, 0, 0, 0)}}, "mix ... exceed 0"),
        ({"people": {"reaction_shares": (-1, 1, 1, 1)}}, "people.reaction_shares.0 ... -1"),
        ({"people": {"speeds": {"mean_mps": NAN}}}, "people.speeds.mean_mps ... nan"),
        ({"people": {"speeds": {"mean": 1.0}}}, "people.speeds.mean ... unknown ... mean_mps"),
        (
            {"people": {"reactions": [{"gian": 1.0}] * 4}},
            "people.reactions.0.gian ... unknown ... gain, range_m, attraction_mps2",
        ),
        ({"drive": {"nominal_speed_mps": 2.5}}, "drive.nominal_speed_mps ... 2.5"),
        (
            {"scenario": "E*", "people": {"model": "replay"}},
            "walkers ... 'replay'",
        ),
        ({"people": {"walkers": [{"x_m": 1.0}]}}, "people.walkers.0.y_m ... required"),
        (
            {"people": {"walkers": [{"x_m": 1, "y_m": 1, "vx_mps": 0, "vy_mps": NAN}]}},
            "people.walkers.0.vy_mps ... nan",
        ),
        (
            {"sensors": {"tracker": {"latency_steps": 51}}},
            "sensors.tracker.latency_steps ... 51",
        ),
        ({"reward": {"contact": NAN}}, "reward.contact ... nan"),
        ({"max_episode_steps": True}, "max_episode_steps ... True ... int"),
        ({"max_episode_steps": "20"}, "max_episode_steps ... '20' ... int"),
        ({"max_episode_steps": 20.0}, "max_episode_steps ... 20.0 ... int"),
        ({"max_episode_steps": 10**12}, "max_episode_steps ... 1000000000000 ... 100000"),
        ({"max_episode_steps": 10**5000}, "max_episode_steps ... thousands"),
        ({"arrival_tolerance_m": True}, "arrival_tolerance_m ... True"),
        ({"sensors": {"tracker": {"range_m": "8"}}}, "sensors.tracker.range_m ... '8'"),
        ({"sensors": {"ultrasonic": {"gaussian": 1}}}, "sensors.ultrasonic.gaussian ... 1"),
        ({"sensors": {"ring": "eight"}}, "sensors.ring ... 'eight' ... 'paper' or 'six'"),
        ({"sensors": {"ring": []}}, "sensors.ring ... 0 ... 1 to 16"),
        ({"sensors": {"ring": ring(**{f"s{i}": 0.1 for i in range(17)})}}, "ring ... 17 ... 16"),
        ({"sensors": {"ring": ring(a=4.0)}}, "sensors.ring.0.angle_rad ... 4.0 ... 3.14"),
        ({"sensors": {"ring": [["a", 0.0, 2.0]]}}, "sensors.ring.0 ... 2.0 ... 1"),
        ({"sensors": {"ring": [["a", 0.0, None], ["b", 0.0]]}}, "ring.1 ... ['b', 0.0] ... all 3"),
        ({"sensors": {"ring": ring(A=0.0)}}, "sensors.ring ... name ... 'A' ... a-z"),
        ({"sensors": {"ring": [*ring(a=0.0), *ring(a=1.0)]}}, "sensors.ring ... 'a' twice"),
        ({"sensors": {"ring": ring(a=0.0, b=1.0, c=2.0, d=3.0)}}, "a, b, c, d ... front_left"),
        (
            {"sensors": {"ring": ring(front_left=0.26, front_right=0.3, left=1.6, right=-1.6)}},
            "angle_rad ... 0.3 ... 'front_right' ... -0.262",
        ),
        (
            {"sensors": {"ring": ring(behind=3.0)}, "drive": {"reflex_stop_m": 0.5}},
            "drive.reflex_stop_m ... 0.5 ... sensors.ring ... 0",
        ),
        ({"people": {"count": ["1", 2]}}, "people.count.0 ... '1' ... int"),
        ({"people": {"count": (10**6, 10**6)}}, "people.count.0 ... 1000000 ... 64"),
        ({"people": {"walkers": [WALKER] * 65}}, "people.walkers ... 64"),
        ({"place_options": {"width_m": 1e300}}, "place_options.width_m ... 1e+300"),
        ({"reward": {"contact": -1e300}}, "reward.contact ... -1e+300"),
        ({"drive": {"chassis": {"r": 1e-300}}}, "chassis.r ... 1e-300"),
        ({"clock": {"physics_s": 1e-9}}, "clock.physics_s ... 1e-09 ... 0.0001"),
        ({"clock": {"decision_s": 1e6}}, "clock.decision_s ... 1000000.0 ... 10"),
        (
            {"clock": {"physics_s": 1e-3, "decision_s": 1.5}},
            "physics_s ... 0.001 ... 1000 ... decision_s",
        ),
        ({"gas": 3}, "gas ... 3 ... dictionary"),
        ({"gas": {"leek": 1}}, "gas.leek ... unknown ... sensor, leak_share"),
        ({"gas": {"leak_share": 1.5}}, "gas.leak_share ... 1.5 ... 1"),
        ({"gas": {"strength_ppm": [5.0, 1.0]}}, "gas ... strength_ppm ... (5.0, 1.0) ... exceed"),
        ({"gas": {"draught_mps": [0.5, 0.2]}}, "gas ... draught_mps ... (0.5, 0.2) ... exceed"),
        ({"gas": {"draught_mps": [0.0, 0.2]}}, "gas.draught_mps.0 ... 0.0 ... greater than 0"),
        ({"gas": {"draught_mps": [0.2, 10.5]}}, "gas.draught_mps.1 ... 10.5 ... 10"),
        ({"gas": {"plume": {"sigma0_m": 1e-6}}}, "gas.plume.sigma0_m ... 1e-06 ... 0.001"),
        ({"gas": {"plume": {"sigma_m": 1.0}}}, "gas.plume.sigma_m ... unknown ... sigma0_m"),
        ({"gas": {"sensor": "TGS1"}}, "gas.sensor ... 'TGS1' ... 'TGS2611', 'TGS2620'"),
        ({"gas": {"sensor": {"rise_s": 1.0}}}, "gas.sensor.decay_s ... required"),
        ({"gas": {"sensor": {**SENSOR, "rise_s": -1.0}}}, "gas.sensor.rise_s ... -1.0"),
        ({"gas": {"sensor": {**SENSOR, "tau_s": 1.0}}}, "gas.sensor.tau_s ... unknown ... rise_s"),
        ({"a\nkey": 1}, "a\\nkey ... unknown"),
        ({"tier": "x" * 1000}, "tier ... " + "x" * 116),
        ({"scenario": "E7"}, "scenario ... 'E7' ... E*, E5.5, C*, C90"),
    ],
)
def test_bad_value_is_one_line_with_field_value_and_what_is_allowed(
    overrides: dict[str, Any], complaint: str
) -> None:
    with refused(complaint):
        make_config(**overrides)


@pytest.mark.parametrize(
    ("clock", "complaint"),
    [
        ({"physics_s": 0.03}, "physics_s ... social_s ... 0.05 / 0.03"),
        ({"social_s": 0.03}, "social_s ... decision_s ... 0.1 / 0.03"),
        ({"social_s": 0.2}, "social_s ... decision_s ... 0.1 / 0.2"),
        ({"social_s": 0.0}, "clock.social_s ... 0.0 ... greater than 0"),
        ({"physics_s": NAN}, "clock.physics_s ... nan ... finite number"),
    ],
)
def test_periods_that_do_not_divide_are_refused(clock: dict[str, float], complaint: str) -> None:
    with refused(complaint):
        make_config(clock=clock)


def test_periods_that_divide_are_counted() -> None:
    clock = Clock(physics_s=0.001, social_s=0.1, decision_s=0.3)  # 0.3 / 0.1 < 3 in floats

    assert (clock.physics_per_social, clock.social_per_decision) == (100, 3)


def test_numbers_of_numpy_are_numbers() -> None:
    people = {"count": (np.int64(1), np.int32(2)), "speeds": {"mean_mps": np.float32(1.5)}}
    config = make_config(max_episode_steps=np.int64(7), people=people)

    assert (config.max_episode_steps, config.people.count) == (7, (1, 2))
    assert type(config.max_episode_steps) is int
    assert config.people.speeds.mean_mps == 1.5


def test_integer_will_do_for_a_float_and_a_list_for_a_tuple() -> None:
    config = make_config(arrival_tolerance_m=1, people={"count": [1, 2], "mix": [1, 0, 0, 0]})

    assert type(config.arrival_tolerance_m) is float
    assert config.people.mix == (1.0, 0.0, 0.0, 0.0)


def test_config_cannot_be_changed() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        Config().tier = "sonar"  # type: ignore[misc]


def test_later_layers_win_over_earlier_ones() -> None:
    preset = {"tier": "sonar", "max_episode_steps": 10, "people": {"count": (1, 1)}}
    given = {"max_episode_steps": 20, "drive": {"start_speed_mps": 0.1}}
    config = make_config(given, preset=preset, scenario="E*", drive={"plant": "B"})

    assert config.tier == "sonar", "from the preset"
    assert config.place == "open", "from the scenario"
    assert config.people.count == (1, 1), "beside what the scenario says about people"
    assert len(config.people.walkers) == 1
    assert config.max_episode_steps == 20, "given, over the preset"
    assert config.drive.start_speed_mps == 0.1, "given, over the scenario's 0.5"
    assert config.drive.wheel_loop == "ideal", "from the scenario"
    assert config.drive.plant == "B", "overridden"


def test_delta_on_a_whole_config_leaves_the_rest_of_its_sections_alone() -> None:
    base = make_config(people={"speeds": {"sd_mps": 0.1}}, drive={"plant": {"K": 3.0}})
    config = make_config(base, people={"speeds": {"mean_mps": 1.0}}, drive={"plant": {"a": 0.0}})

    assert config.people.speeds == base.people.speeds._replace(mean_mps=1.0)
    assert not isinstance(config.drive.plant, str)
    assert (config.drive.plant.K, config.drive.plant.a) == (3.0, 0.0)


def test_a_part_of_what_was_given_as_a_list_is_refused() -> None:
    with refused("reward ... {'burden': 0} ... 7"):
        make_config({"reward": [1.0] * 7}, reward={"burden": 0})


@pytest.mark.parametrize("scenario", [None, *SCENARIOS])
def test_config_survives_being_written_down(scenario: str | None) -> None:
    plant = PLANTS["B"]._replace(K=2.5)._asdict()
    config = make_config(scenario=scenario, drive={"plant": plant}, tracks="somewhere")

    assert Config.model_validate(config.model_dump()) == config
    assert Config.model_validate_json(config.model_dump_json()) == config
    assert make_config(yaml.safe_load(yaml.safe_dump(config.model_dump(mode="json")))) == config
    assert make_config(config) == config


@pytest.mark.parametrize("scenario", ["E*", "E5.5", "C*", "C90", "E-experiment", "C-experiment"])
def test_meetings_of_the_paper_are_with_one_walker_at_the_robots_speed(scenario: str) -> None:
    config = make_config(scenario=scenario)
    (walker,) = config.people.walkers

    assert math.hypot(walker.vx_mps, walker.vy_mps) == pytest.approx(0.5)
    assert config.drive.nominal_speed_mps == 0.5


@pytest.mark.parametrize("scenario", ["E*", "E5.5", "C*", "C90"])
def test_simulations_of_the_paper_are_without_noise_and_begin_at_full_speed(scenario: str) -> None:
    config = make_config(scenario=scenario)

    assert config.drive.start_speed_mps == config.drive.nominal_speed_mps
    assert config.sensors.tracker.position_noise_m == 0.0


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_every_named_scenario_makes_a_config(scenario: str) -> None:
    assert make_config(scenario=scenario) != make_config()


def test_file_of_deltas_is_read(tmp_path: Path) -> None:
    path = tmp_path / "night.yaml"
    path.write_text("tier: sonar\npeople: {count: [1, 2]}\n")

    for given in (path, str(path)):
        config = make_config(given, max_episode_steps=9)
        assert (config.tier, config.people.count, config.max_episode_steps) == ("sonar", (1, 2), 9)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"tier: [", "YAML"),
        (b"\xff\xfe\xff", "YAML"),
        (b"- tier", "list ... mapping"),
        (b"tier: sonar\ntier: tracks", "line 2 ... 'tier'"),
        (b"tear: sonar", "tear ... unknown ... place"),
    ],
)
def test_bad_file_is_one_clear_line(tmp_path: Path, content: bytes, complaint: str) -> None:
    path = tmp_path / "night.yaml"
    path.write_bytes(content)

    with refused(complaint):
        make_config(path)


def test_config_of_another_kind_is_one_clear_line() -> None:
    with refused("config ... int ... Config ... mapping"):
        make_config(3)  # type: ignore[arg-type]


def test_missing_file_is_one_clear_line() -> None:
    with refused("config ... no/such.yaml ... No such file"):
        make_config("no/such.yaml")
