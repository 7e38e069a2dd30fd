"""Distributions in place of config values are drawn by the scenario's key."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import Config, make_config
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.randomised import draw_config

SPEED = {"uniform": [1.0, 1.6]}


def draws(config: Config, name: str) -> list[Any]:
    return [draw_config(config, key).values[name] for key in range(400)]


def test_a_uniform_number_is_drawn_between_its_ends() -> None:
    config = make_config(drive={"acceleration_mps2": {"uniform": [0.3, 0.5]}})
    values = draws(config, "drive.acceleration_mps2")

    assert config.drive.acceleration_mps2 == 0.4
    assert 0.3 < min(values) < 0.31
    assert 0.49 < max(values) < 0.5
    assert np.mean(values) == pytest.approx(0.4, abs=0.01)
    assert draw_config(config, 7).config.drive.acceleration_mps2 == values[7]


def test_whole_numbers_are_drawn_for_whole_numbers_both_ends_included() -> None:
    config = make_config(people={"count": [{"uniform": [1, 3]}, {"choice": [4, 8]}]})
    assert set(draws(config, "people.count.0")) == {1, 2, 3}
    assert set(draws(config, "people.count.1")) == {4, 8}


def test_whole_ends_of_a_real_number_do_not_make_it_whole() -> None:
    config = make_config(people={"speeds": {"mean_mps": {"uniform": [1, 2]}}})
    assert len(set(draws(config, "people.speeds.mean_mps"))) == 400


def test_a_normal_number_is_truncated_at_three_standard_deviations() -> None:
    config = make_config(people={"speeds": {"mean_mps": {"normal": [1.3, 0.1]}}})
    values = draws(config, "people.speeds.mean_mps")
    assert np.mean(values) == pytest.approx(1.3, abs=0.02)
    assert np.std(values) == pytest.approx(0.1, abs=0.015)
    assert max(np.abs(np.array(values) - 1.3)) == pytest.approx(0.3)  # of 400, some are cut


def test_a_draw_does_not_depend_on_what_else_is_randomised() -> None:
    one = make_config(people={"speeds": {"mean_mps": SPEED}})
    two = make_config(one, drive={"acceleration_mps2": {"uniform": [0.3, 0.5]}})
    assert draws(one, "people.speeds.mean_mps") == draws(two, "people.speeds.mean_mps")


def test_names_are_chosen_like_numbers() -> None:
    config = make_config(drive={"plant": {"choice": ["A", "B"]}})
    assert set(draws(config, "drive.plant")) == {"A", "B"}


def test_a_value_replaces_a_distribution_and_the_reverse() -> None:
    config = make_config(people={"speeds": {"mean_mps": SPEED}})
    assert make_config(config, people={"speeds": {"mean_mps": 1.2}}).randomised == {}
    again = make_config(config, people={"speeds": {"mean_mps": {"choice": [1.1, 1.2]}}})
    assert again.randomised == {"people.speeds.mean_mps": {"choice": [1.1, 1.2]}}


def test_a_config_survives_json() -> None:
    config = make_config(
        people={"count": [2, {"uniform": [3, 6]}]}, reward={"intrusion": {"normal": [-0.4, 0.1]}}
    )
    assert make_config(json.loads(config.model_dump_json())) == config


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"drive": {"acceleration_mps2": {"uniform": [0.5, 0.3]}}}, "allowed is uniform: \\[low"),
        ({"drive": {"acceleration_mps2": {"normal": [0.5]}}}, "allowed is normal: \\[mean"),
        ({"people": {"count": {"uniform": [1, 6]}}}, "count: given .*, allowed is a .* single"),
        ({"people": {"speeds": {"normal": [1, 0.1]}}}, "speeds: given .*, allowed is a .* single"),
        ({"drive": {"acceleration_mps2": {"uniform": [0, 10**400]}}}, "allowed is uniform: \\[low"),
        (
            {"drive": {"acceleration_mps2": {"uniform": [0.3, 0.5], "normal": [0.4, 0.1]}}},
            "drive.acceleration_mps2: given .*, allowed is one of uniform, normal, choice",
        ),
        (
            {"people": {"count": [1, {"uniform": [2.5, 6]}]}},
            r"people.count.1: given {'uniform': \[2.5, 6\]}: .* valid integer",
        ),
        ({"drive": {"acceleration_mps2": {"choice": []}}}, "list of values to choose from"),
        ({"drive": {"acceleration_mps2": {"uniform": [-0.1, 0.5]}}}, "includes -0.1: drive"),
        ({"sensors": {"tracker": {"dropout": {"normal": [0.1, 0.05]}}}}, "includes -0.0"),
        ({"people": {"count": [{"uniform": [1, 4]}, 3]}}, "includes 4: people: count"),
        ({"max_episode_steps": {"choice": [100, 200]}}, "same in all episodes"),
        ({"clock": {"social_s": {"choice": [0.05, 0.1]}}}, "same in all episodes"),
        ({"gas": {"choice": [None, {}]}}, "same in all episodes"),
        ({"drive": {"accelaration": {"uniform": [0.3, 0.5]}}}, "accelaration: unknown key"),
        ({"randomised": {"people.count.7": {"uniform": [0, 1]}}}, "which is no field"),
    ],
)
def test_a_mistake_is_refused_in_one_line(given: dict[str, Any], reason: str) -> None:
    with pytest.raises(InvalidInput, match=reason) as refused:
        make_config(make_config(), **given)
    assert "\n" not in str(refused.value)


def test_a_config_that_is_a_distribution_is_refused() -> None:
    with pytest.raises(InvalidInput, match="allowed is a mapping of fields"):
        make_config({"uniform": [0, 1]})


def test_values_that_do_not_fit_each_other_are_refused_with_their_scenario() -> None:
    config = make_config(people={"count": [{"uniform": [1, 5]}, {"uniform": [5, 9]}]})
    draw_config(config, 0)
    clash = make_config(people={"count": [{"choice": [1, 4]}, {"choice": [5, 4, 4]}]})
    broken = clash.model_copy(
        update={"randomised": clash.randomised | {"people.count.0": {"choice": [9]}}}
    )
    with pytest.raises(InvalidInput, match=r"count.*\(randomised, scenario 3\)"):
        draw_config(broken, 3)
