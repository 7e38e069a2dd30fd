from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from hazbot_gym.policies import make
from hazbot_gym.policies.fuzzy_expert import AVOIDANCE_M, FuzzyExpert
from hazbot_gym.policies.fuzzy_readings import READINGS, FuzzyReading
from hazbot_gym.task.observation import LAYOUTS
from tests.refusals import refused

TRACKS = LAYOUTS["tracks"]


def observe(
    distance_m: float,
    pattern: str = "encountering",
    *,
    human_mps: float = 0.5,
    v: float = 0.0,
    command: float = 0.5,
    bearing_cos: float = 1.0,
    closing_mps: float = 0.5,
) -> npt.NDArray[np.float32]:
    """Return a robot's observation of one person."""
    seen = {
        "speed_mps": v,
        "command_mps": command,
        "person0_present": 1.0,
        "person0_distance_m": distance_m,
        "person0_speed_mps": human_mps,
        "person0_bearing_cos": bearing_cos,
        "person0_closing_mps": closing_mps,
        f"person0_{pattern}": 1.0,
    }
    row = np.zeros(TRACKS.width, np.float32)
    for name, value in seen.items():
        column = TRACKS.names.index(name)
        row[column] = value / TRACKS.fields[column].scale
    return row


def kept(policy: Any, observation: Any, state: Any = None) -> float:
    return float(policy.predict(observation, state)[0][0] + 1.0) / 2.0


def reading(name: str, **options: Any) -> FuzzyReading:
    return FuzzyReading(reading=name, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", READINGS)
def test_every_reading_can_be_made_by_its_name_and_differs_from_the_strategy(name: str) -> None:
    policy, chosen = make(f"fuzzy_reading:reading={name}"), FuzzyExpert()
    state = np.full((), 1.0) if name == "elapsed" else None
    rows = [
        observe(d, pattern, human_mps=human, v=0.3, command=0.4)
        for d in (1.4, 2.2, 2.6, 3.95)
        for pattern in ("crossing", "encountering", "leading", "confronting")
        for human in (0.5, 1.0)
    ]
    apart = [abs(kept(policy, row, state) - kept(chosen, row)) for row in rows]
    assert max(apart) > 0.01


@pytest.mark.parametrize("distance_m", [1.6, 2.0, 2.5, 2.9])
def test_percentages_taken_away_leave_the_rest(distance_m: float) -> None:
    row = observe(distance_m)
    assert kept(reading("inverted"), row) == pytest.approx(1.0 - kept(FuzzyExpert(), row))


def test_inverted_robot_drives_on_at_the_sensitive_distance() -> None:
    assert kept(reading("inverted"), observe(1.4)) > 0.9


def test_centroid_never_stops_the_robot() -> None:
    answers = [kept(reading("centroid"), observe(d)) for d in np.linspace(0.3, 2.0, 18)]
    assert min(answers) > 0.05
    assert kept(FuzzyExpert(), observe(1.4)) == 0.0


@pytest.mark.parametrize("name", READINGS)
def test_whoever_is_behind_and_recedes_is_let_go_on_demand(name: str) -> None:
    leaving = observe(2.0, bearing_cos=-0.9, closing_mps=-0.5)
    assert kept(reading(name, release=True), leaving) == 1.0
    assert kept(reading(name), leaving) < 1.0


def test_recursive_reading_takes_its_share_of_the_present_command() -> None:
    one = kept(FuzzyExpert(), observe(2.5))
    assert kept(reading("recursive"), observe(2.5, command=0.2)) == pytest.approx(one * 0.4)
    assert kept(reading("recursive"), observe(8.0, command=0.0)) == 0.0


def test_fixed_horizon_answers_to_where_the_robot_will_be() -> None:
    assert kept(reading("horizon"), observe(2.7, v=0.4)) == pytest.approx(
        kept(FuzzyExpert(), observe(2.3)), abs=1e-6
    )
    for t_s in (0.5, 1.0):
        expert = FuzzyExpert(horizon_s=t_s)
        assert kept(expert, observe(2.7, v=0.4)) == pytest.approx(
            kept(FuzzyExpert(), observe(2.7 - 0.4 * t_s)), abs=1e-6
        )
        assert kept(expert, observe(2.7, v=0.0)) == kept(FuzzyExpert(), observe(2.7))


def test_elapsed_time_grows_with_every_decision_and_starts_anew_with_an_episode() -> None:
    policy, state = reading("elapsed"), None
    rows = np.stack([observe(2.8, v=0.5)] * 2)
    shares = []
    for k in range(11):
        starts = np.array([False, k == 10])
        actions, state = policy.predict(rows, state, starts)
        shares.append((actions[:, 0] + 1.0) / 2.0)
    same = [kept(FuzzyExpert(), observe(2.8 - 0.5 * 0.1 * k)) for k in range(11)]
    assert [share[0] for share in shares] == pytest.approx(same, abs=1e-6)
    assert shares[-1][1] == pytest.approx(same[0], abs=1e-6)


def test_elapsed_time_is_refused_on_the_sonar_tier_in_one_line() -> None:
    blank = np.zeros(LAYOUTS["sonar"].width, np.float32)
    with refused("reading ... 'elapsed' ... tracked people"):
        reading("elapsed").predict(blank)


def test_terms_of_the_span_lie_on_the_way_between_the_limits() -> None:
    centres = reading("span").controller.distance[:, 0]
    assert centres == pytest.approx([1.5, 2.625, 2.85, 3.0])


def test_without_the_gate_the_tail_of_the_widest_term_slows_the_robot_far_away() -> None:
    # DS is the widest set: where all others are all but nil, it is what is left of the sum.
    far_m = np.arange(3.05, 4.5, 0.05)
    answers = [kept(reading("no_gate"), observe(float(d))) for d in far_m]
    assert min(answers) < 0.98
    assert far_m[int(np.argmin(answers))] > 3.7
    assert all(kept(FuzzyExpert(), observe(float(d))) == 1.0 for d in far_m if d > AVOIDANCE_M)
