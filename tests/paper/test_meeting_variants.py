"""Details of the meetings that the paper leaves open."""

from __future__ import annotations

import pytest

from hazbot_gym.config import make_config
from hazbot_gym.paper.numbers import reported, verdict
from hazbot_gym.paper.sections.meetings.experiment import events
from hazbot_gym.paper.sections.meetings.variants import CHOSEN, REFIT, WIDE, by_width, front_wall
from hazbot_gym.paper.sections.meetings.variants import jump_of_wide_terms as jump

TOLD = {"C*": "crossing_sim", "E*": "encountering_sim"}


def test_only_wide_terms_with_a_crossing_for_them_meet_all_four_times_of_the_simulations() -> None:
    missed = {}
    for name, runs in by_width().items():
        found = {scenario: events(run) for scenario, run in runs.items()}
        here = {
            f"{TOLD[scenario]}_{what}_s": getattr(each, f"{what}_s")
            for scenario, each in found.items()
            for what in ("decelerates", "stops")
        }
        missed[name] = {
            number
            for number, value in here.items()
            if verdict(reported().numbers[number], value) != "reproduced"
        }
    assert missed == {
        CHOSEN: {"encountering_sim_stops_s"},
        WIDE: {"crossing_sim_stops_s"},
        REFIT: set(),
    }


def test_wide_terms_cost_a_jump_at_3_m() -> None:
    assert jump() == pytest.approx(0.09, abs=0.01)  # docs/paper.md, section 5.1


def test_the_robot_stands_before_a_front_wall_after_the_human_has_passed() -> None:
    wall = front_wall(range(3))
    told = reported().numbers["crossing_exp_wall_s"].paper
    assert 0.1 < wall.gap_m < make_config(scenario="C-experiment+wall").drive.reflex_stop_m
    assert wall.slows_s > told + 5.0
