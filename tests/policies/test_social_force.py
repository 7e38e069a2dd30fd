from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from hazbot_gym.core.social_force import HELBING_MOLNAR_1995
from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.paper.sections.meetings.experiment import events, meet
from hazbot_gym.policies.social_force import RADII_M, SocialForceSpeed
from hazbot_gym.task.observation import LAYOUTS

TRACKS = LAYOUTS["tracks"]
TAU_S, DT_S = HELBING_MOLNAR_1995.relaxation_time_s, 0.1


def observe(
    *people: tuple[float, float], v: float = 0.5, closing_mps: float = 0.0
) -> npt.NDArray[np.float32]:
    """Return the observation by a robot at v of people at a clearance [m] and a bearing [deg]."""
    seen = {"speed_mps": v}
    for i, (clearance_m, bearing_deg) in enumerate(people):
        seen[f"person{i}_present"] = 1.0
        seen[f"person{i}_closing_mps"] = closing_mps
        seen[f"person{i}_distance_m"] = clearance_m + RADII_M
        seen[f"person{i}_bearing_cos"] = math.cos(math.radians(bearing_deg))
        seen[f"person{i}_bearing_sin"] = math.sin(math.radians(bearing_deg))
    row = np.zeros(TRACKS.width, np.float32)
    for name, value in seen.items():
        column = TRACKS.names.index(name)
        row[column] = value / TRACKS.fields[column].scale
    return row


def speed(observation: npt.NDArray[np.float32], **options: float) -> float:
    """Return the speed that is commanded [m/s]."""
    action = SocialForceSpeed(**options).predict(observation)[0]
    return 0.25 * float(action[0] + 1.0)


def test_alone_it_relaxes_to_the_nominal_speed() -> None:
    assert speed(observe(v=0.5)) == pytest.approx(0.5)
    assert speed(observe(v=0.1)) == pytest.approx(0.1 + (0.5 - 0.1) / TAU_S * DT_S)


def test_force_of_a_person_ahead_by_hand() -> None:
    push = HELBING_MOLNAR_1995.robot_strength_mps2 * math.exp(-1.2 / 0.3)
    expected = 0.4 + ((0.5 - 0.4) / TAU_S - push) * DT_S
    assert speed(observe((1.2, 0.0), v=0.4)) == pytest.approx(expected, abs=1e-6)


def test_person_out_of_view_counts_less_and_pushes_the_robot_on() -> None:
    push = HELBING_MOLNAR_1995.robot_strength_mps2 * math.exp(-1.2 / 0.3)
    expected = 0.2 + ((0.5 - 0.2) / TAU_S + 0.5 * push) * DT_S
    assert speed(observe((1.2, 180.0), v=0.2)) == pytest.approx(expected, abs=1e-6)


def test_person_beside_does_not_change_the_speed() -> None:
    assert speed(observe((0.5, 90.0), v=0.4)) == pytest.approx(speed(observe(v=0.4)), abs=1e-6)


def test_nearer_people_and_more_strength_mean_less_speed() -> None:
    by_clearance = [speed(observe((c, 20.0), v=0.3)) for c in (2.0, 1.2, 0.9, 0.6, 0.1)]
    assert by_clearance == sorted(by_clearance, reverse=True)
    assert by_clearance[-1] == 0.0 < by_clearance[0]
    by_strength = [speed(observe((1.2, 20.0), v=0.3), strength=s) for s in (0.0, 1.0, 4.0)]
    assert by_strength == sorted(by_strength, reverse=True)
    assert by_strength[0] == pytest.approx(speed(observe(v=0.3)))


def test_forces_of_several_people_add_up() -> None:
    pushes = [speed(observe(v=0.4)) - speed(observe(one, v=0.4)) for one in ((1.2, 0.0), (1.4, 30))]
    both = speed(observe(v=0.4)) - speed(observe((1.2, 0.0), (1.4, 30), v=0.4))
    assert both == pytest.approx(sum(pushes), abs=1e-6)


@pytest.mark.parametrize("clearance_m", [1.2, 0.9, 0.6, 0.3])
def test_whoever_comes_is_answered_at_least_as_hard_as_who_stands(clearance_m: float) -> None:
    # A repulsion along the relative step cancels itself on the line of sight, and once did.
    standing, coming = (observe((clearance_m, 0.0), v=0.4, closing_mps=c) for c in (0.4, 1.0))
    assert speed(coming) <= speed(standing) < speed(observe(v=0.4))


@pytest.mark.parametrize("strength", [1.0, 16.0])
def test_somebody_who_comes_straight_at_it_finds_it_standing(strength: float) -> None:
    walker = {"x_m": 4.5, "y_m": 0.0, "vx_mps": -0.5, "vy_mps": 0.0}
    (met,) = meet(
        "E*", SocialForceSpeed(strength=strength), overrides={"people": {"walkers": [walker]}}
    )
    assert met.is_touching  # walkers of the script do not stop
    assert abs(met.speed_mps[-1]) < 0.025
    assert events(met).hits == 0.0


def test_it_arrives_in_the_paper_s_scenarios_on_the_drive_in_earnest() -> None:
    for scenario in ("E-experiment", "C-experiment"):
        (row,) = evaluate(
            "social_force", "hazbot_gym/Corridor-v1", episodes=1, overrides={"scenario": scenario}
        )
        assert row["outcome"] == "arrived"
