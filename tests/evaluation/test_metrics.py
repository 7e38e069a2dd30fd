from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.discomfort import discomfort
from hazbot_gym.core.state import GAS, Records, records
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.evaluation.metrics import (
    GAS_HEADLINE,
    HEADLINE,
    SsmThresholds,
    clearances,
    distances,
    means,
    measure,
    protective_distance,
)

R, R_I = 0.3, 0.2  # radii of robot and person [m]
SSM = SsmThresholds()


def episode(**changes: object) -> Episode:
    """Four decisions of 0.1 s at 0.5 m/s along x, one person 2 m ahead of the start, standing."""
    time = np.arange(5) * 0.1
    x = 0.5 * time
    person = np.array([2.0, 0.0, 0.0, 0.0, R_I])
    plain = Episode(
        time_s=time,
        pose=np.column_stack([x, 0 * x, 0 * x]),
        speed_mps=np.full(5, 0.5),
        command_mps=np.full(5, 0.5),
        pose_error=np.zeros((5, 3)),
        people=np.tile(person, (5, 1, 1)),
        people_alone=np.full((5, 1, 2), np.nan),
        rewards=np.array([1.0, 2.0, 3.0, -1.0]),
        reward_terms={"progress": np.array([1.0, 1.0, 0.5, 0.0])},
        costs=np.array([0.0, 0.1, 0.2, 0.0]),
        outcome="arrived",
        contact_caused_by="",
        contact_speed_mps=float("nan"),
        time_free_s=0.2,
        horizon_s=2.0,
        robot_radius_m=R,
        deceleration_mps2=1.0,
        nominal_mps=0.5,
        sensor_rise_s=4.0,  # 1 m in 4 s: 0.25 m/s
        gas=records(GAS, 0),
    )
    changed: Episode = plain._replace(**changes)
    return changed._replace(people_alone=np.full((*changed.people.shape[:2], 2), np.nan))


def test_clearance_is_centre_distance_less_both_radii() -> None:
    np.testing.assert_allclose(distances(episode())[:, 0], [2.0, 1.95, 1.9, 1.85, 1.8])
    np.testing.assert_allclose(
        clearances(episode(), distances(episode()))[:, 0], [1.5, 1.45, 1.4, 1.35, 1.3]
    )


def test_an_absent_person_is_infinitely_far() -> None:
    nobody = episode(people=np.full((5, 2, 5), np.nan))
    assert np.isinf(clearances(nobody, distances(nobody))).all()
    row = measure(nobody, SSM)
    assert row["clearance_min_m"] == np.inf
    assert row["personal_m"] == row["discomfort_s"] == row["ssm_violation"] == 0.0


def test_an_episode_without_anybody_measures_like_one_with_absent_people() -> None:
    empty = measure(episode(people=np.zeros((5, 0, 5))), SSM)
    assert empty == pytest.approx(
        measure(episode(people=np.full((5, 2, 5), np.nan)), SSM), nan_ok=True
    )


def test_protective_distance_agrees_with_the_sum_worked_out_by_hand() -> None:
    # v = 0.5: 1.6 * (0.1 + 0.5) + 0.5 * 0.1 + 0.25 / 2 + 0.45 + 0.1
    assert protective_distance(np.array(0.5), SSM) == pytest.approx(1.685)


def test_protective_distance_inverts_to_the_published_speed_limits() -> None:
    # v_max(c) of the closed-form inverse at clearances 1.2, 2.0 and 3.6 m, to two decimals.
    speeds = np.array([0.27, 0.64, 1.24])
    np.testing.assert_allclose(protective_distance(speeds, SSM), [1.2, 2.0, 3.6], atol=0.015)


def test_ssm_violation_is_the_share_of_moving_steps_that_are_too_near() -> None:
    speed = np.array([0.5, 0.5, 0.0, 0.5, 0.5])  # stands at the second decision
    people = episode().people.copy()
    people[3, 0, 0] = 10.0  # far away at the third decision only
    row = measure(episode(speed_mps=speed, people=people), SSM)
    assert row["ssm_violation"] == pytest.approx(2 / 3)
    # Clearances 1.45 and 1.3 against 1.685; the far step falls short by nothing.
    assert row["ssm_shortfall_m"] == pytest.approx((0.235 + 0.0 + 0.385) / 3)


def test_a_robot_that_never_moves_violates_no_separation() -> None:
    row = measure(episode(speed_mps=np.full(5, 0.04)), SSM)
    assert (row["ssm_violation"], row["ssm_shortfall_m"]) == (0.0, 0.0)


def test_distance_in_the_zones_counts_while_anybody_is_inside() -> None:
    people = np.tile(np.array([[9.0, 0, 0, 0, R_I], [9.0, 5, 0, 0, R_I]]), (5, 1, 1))
    people[1, 0, 0] = 0.05 + R + R_I + 1.1  # personal
    people[2, :, 0] = 0.10 + R + R_I + 0.4  # intimate
    people[2, 1, 1] = 0.0
    people[4, 1] = (0.20, R + R_I + 0.5, 0, 0, R_I)  # personal
    row = measure(episode(people=people, speed_mps=np.array([0.5, 0.5, 0.4, 0.5, 0.2])), SSM)
    assert row["personal_m"] == pytest.approx(0.1 * (0.5 + 0.4 + 0.2))
    assert row["intimate_m"] == pytest.approx(0.1 * 0.4)
    assert row["driven_m"] == pytest.approx(0.1 * (0.5 + 0.4 + 0.5 + 0.2))


def test_discomfort_is_that_of_one_person_at_the_square_of_the_speed() -> None:
    near, far = [0.0, 1.0, 0.0, -1.0, R_I], [0.0, -2.0, 0.0, 1.0, R_I]  # both come to the robot
    people = np.tile(np.array([near, far, np.full(5, np.nan)]), (5, 1, 1))
    row = measure(episode(pose=np.zeros((5, 3)), people=people, speed_mps=np.full(5, 0.25)), SSM)
    assert row["discomfort_s"] == pytest.approx(discomfort(0.5, 1.0) * 0.25 * 0.4)


def test_waiting_beside_a_person_disturbs_nobody() -> None:
    near = np.tile(np.array([0.8, 0, 0, 0, R_I]), (5, 1, 1))
    row = measure(episode(pose=np.zeros((5, 3)), people=near, speed_mps=np.zeros(5)), SSM)
    assert row["personal_m"] == row["intimate_m"] == row["discomfort_s"] == 0.0


def test_constant_speed_has_neither_acceleration_nor_jerk() -> None:
    row = measure(episode(), SSM)
    assert row["rms_acceleration_mps2"] == pytest.approx(0.0)
    assert row["rms_jerk_mps3"] == pytest.approx(0.0)


def test_jerk_of_a_sawtooth_speed_is_worked_out_by_hand() -> None:
    row = measure(episode(speed_mps=np.array([0.0, 0.1, 0.0, 0.1, 0.0])), SSM)
    assert row["rms_acceleration_mps2"] == pytest.approx(1.0)  # +1, -1, +1, -1
    assert row["rms_jerk_mps3"] == pytest.approx(20.0)  # -20, +20, -20


def test_cross_track_error_is_the_lateral_part_in_the_frame_of_the_path() -> None:
    # The robot is 0.1 m left of its path and heads 90 degrees to the left: that is x_e = 0.1.
    error = np.tile([0.1, 0.0, np.pi / 2], (5, 1))
    row = measure(episode(pose_error=error), SSM)
    assert row["cross_track_rms_m"] == row["cross_track_max_m"] == pytest.approx(0.1)
    assert row["heading_error_rms_rad"] == pytest.approx(np.pi / 2)


def test_lagging_behind_on_the_path_is_no_cross_track_error() -> None:
    row = measure(episode(pose_error=np.tile([-0.3, 0.0, 0.0], (5, 1))), SSM)
    assert row["cross_track_max_m"] == 0.0


def test_an_arrival_is_timed_against_the_free_time() -> None:
    row = measure(episode(), SSM)
    assert (row["arrived"], row["timeout"]) == (1, 0)
    assert row["time_s"] == pytest.approx(0.4)
    assert (row["time_ratio"], row["delay_s"]) == (pytest.approx(2.0), pytest.approx(0.2))
    assert row["stl"] == pytest.approx(0.5)


@pytest.mark.parametrize("outcome", ["timeout", "contact_person", "contact_wall"])
def test_whoever_does_not_arrive_takes_the_whole_horizon(outcome: str) -> None:
    row = measure(episode(outcome=outcome), SSM)
    assert (row["time_ratio"], row["delay_s"]) == (pytest.approx(10.0), pytest.approx(1.8))
    assert row["stl"] == 0.0


@pytest.mark.parametrize(
    ("outcome", "cause", "column"),
    [
        ("contact_person", "robot", "contact_robot_caused"),
        ("contact_person", "person", "contact_person_caused"),
        ("contact_wall", "robot", "contact_wall"),
        ("timeout", "", "timeout"),
        ("arrived", "", "arrived"),
    ],
)
def test_every_outcome_counts_in_exactly_one_column(outcome: str, cause: str, column: str) -> None:
    row = measure(episode(outcome=outcome, contact_caused_by=cause), SSM)
    columns = (
        "arrived",
        "timeout",
        "contact_robot_caused",
        "contact_person_caused",
        "contact_wall",
    )
    assert {name for name in columns if row[name]} == {column}


def test_a_robot_that_stood_before_the_contact_was_passive() -> None:
    contact = episode(outcome="contact_person", contact_caused_by="person", contact_speed_mps=1.2)
    stood = contact._replace(speed_mps=np.array([0.5, 0.3, 0.1, 0.0, 0.2]))  # pushed at the end
    assert measure(stood, SSM)["contact_passive"] == 1.0
    assert measure(contact, SSM)["contact_passive"] == 0.0
    assert measure(contact, SSM)["contact_speed_mps"] == 1.2
    assert np.isnan(measure(episode(), SSM)["contact_passive"])


def test_return_and_reward_terms_are_plain_sums() -> None:
    row = measure(episode(), SSM)
    assert row["return"] == 5.0
    assert row["reward_progress"] == 2.5
    assert row["cost"] == pytest.approx(0.3)


def test_mirrored_worlds_measure_the_same() -> None:
    people = episode().people.copy()
    people[..., 1] = 0.7
    mirrored = people.copy()
    mirrored[..., [1, 3]] *= -1
    error = np.tile([0.02, 0.05, 0.1], (5, 1))
    one = measure(episode(people=people, pose_error=error), SSM)
    other = measure(episode(people=mirrored, pose_error=error * [1, -1, -1]), SSM)
    assert one == pytest.approx(other, nan_ok=True)


def test_a_profile_names_the_thresholds_that_a_row_was_measured_with() -> None:
    assert measure(episode(), SSM)["ssm_profile"] == SsmThresholds().profile()
    assert SsmThresholds(braking_mps2=0.5).profile() != SSM.profile()


def test_one_decision_is_enough_to_measure() -> None:
    plain = episode()
    short = plain._replace(
        **{
            name: getattr(plain, name)[:2]
            for name in (
                "time_s",
                "pose",
                "speed_mps",
                "command_mps",
                "pose_error",
                "people",
                "people_alone",
            )
        },
        rewards=np.ones(1),
        reward_terms={},
        costs=np.zeros(1),
    )
    row = measure(short, SSM)
    assert row["rms_jerk_mps3"] == 0.0
    assert row["time_s"] == pytest.approx(0.1)


def test_standing_is_needless_while_nobody_is_near_or_coming() -> None:
    speed = np.array([0.5, 0.0, 0.0, 0.5, 0.2])
    near = measure(episode(speed_mps=speed), SSM)  # somebody stands 2 m ahead
    assert near["stalled_s"] == pytest.approx(0.2)
    assert near["stalled_needlessly_s"] == 0.0
    far = episode().people + np.array([8.0, 0.0, 0.0, 0.0, 0.0])
    assert measure(episode(speed_mps=speed, people=far), SSM)[
        "stalled_needlessly_s"
    ] == pytest.approx(0.2)
    coming = far + np.array([0.0, 0.0, -2.5, 0.0, 0.0])  # 9.5 m away, in less than 5 s here
    assert measure(episode(speed_mps=speed, people=coming), SSM)["stalled_needlessly_s"] == 0.0
    assert near["mean_speed_mps"] == pytest.approx(0.7 / 4)
    assert near["inspected_share"] == pytest.approx(0.2 / 0.7)


def test_a_robot_inspects_while_it_needs_the_rise_of_the_sensor_for_a_metre() -> None:
    speed = np.array([0.5, 0.5, 0.1, 0.3, 0.1])

    def share(rise_s: float) -> float:
        return float(
            measure(episode(speed_mps=speed, sensor_rise_s=rise_s), SSM)["inspected_share"]
        )

    assert share(1.0) == 1.0
    assert share(3.0) == pytest.approx(0.5)  # 0.33 m/s
    assert share(4.0) == pytest.approx(0.2)
    assert share(100.0) == 0.0


def sniffed(*, is_there: int = 1, is_reported: int = 1, false_alarms: int = 0) -> Records:
    """Gas of a drive past a leak at 1.0 m; the reading rises steepest at 1.0 m, and peaks at 1.6 m.

    The alarm sounds at the fourth and fifth of five instants.
    """
    gas = records(GAS, 5)
    gas["leak"]["is_there"], gas["leak"]["s_m"] = is_there, 1.0 * is_there
    gas["smell"]["s_m"] = 0.4, 0.7, 1.0, 1.3, 1.6
    gas["smell"]["smooth"] = 0.0, 0.2, 0.8, 1.1, 1.2
    gas["smell"]["smoother"] = 0.0, 0.1, 0.2, 0.8, 1.1
    gas["smell"]["alarm"] = 0, 0, 0, 1, 1
    gas["is_reported"][3:], gas["false_alarms"][3:] = is_reported, false_alarms
    return gas


def leak_of(gas: Records) -> dict[str, Any]:
    row = measure(episode(gas=gas, sensor_rise_s=4.0), SSM)
    return {name: row[name] for name in ("leak", *GAS_HEADLINE)}


def test_a_leak_is_said_to_be_at_the_largest_reading_and_without_lag_at_the_steepest_rise() -> None:
    assert leak_of(sniffed()) == pytest.approx(
        {
            "leak": 1,
            "leak_found": 1.0,
            "false_alarms": 0,
            "time_to_alarm_s": 0.3,
            "leak_error_m": 0.6,
            "leak_error_corrected_m": 0.0,
        }
    )


def test_a_missed_leak_is_nowhere() -> None:
    missed = leak_of(sniffed(is_reported=0, false_alarms=1))
    assert (missed["leak_found"], missed["false_alarms"]) == (0.0, 1)
    assert np.isnan([missed["leak_error_m"], missed["leak_error_corrected_m"]]).all()


def test_without_a_leak_none_is_found_or_missed() -> None:
    silent = sniffed(is_there=0, is_reported=0)
    silent["smell"]["alarm"] = 0
    row = leak_of(silent)
    assert (row["leak"], row["false_alarms"]) == (0, 0)
    names = ("leak_found", "time_to_alarm_s", "leak_error_m", "leak_error_corrected_m")
    assert np.isnan([row[name] for name in names]).all()


def test_means_have_the_columns_of_gas_only_where_there_is_gas() -> None:
    dry, found = measure(episode(), SSM), measure(episode(gas=sniffed()), SSM)
    missed = measure(episode(gas=sniffed(is_reported=0)), SSM)
    assert tuple(means([dry])) == HEADLINE
    both = means([found, missed])
    assert tuple(both) == (*HEADLINE, *GAS_HEADLINE)
    assert both["leak_found"] == 0.5
    assert both["leak_error_m"] == pytest.approx(0.6)  # of the leak found


def test_changes_of_mind_and_hard_brakes_are_counted_once_each() -> None:
    # Accelerations -5, 0, +5, -1 m/s^2: two changes of sign; hard brakes at the first and the last.
    row = measure(episode(speed_mps=np.array([0.5, 0.0, 0.0, 0.5, 0.4])), SSM)
    assert row["reversals_per_min"] == pytest.approx(2 * 60 / 0.4)
    assert row["hard_brakes_per_100m"] == pytest.approx(2 * 100 / 0.09)
    firmer = episode(speed_mps=np.array([0.5, 0.0, 0.0, 0.5, 0.4]), deceleration_mps2=2.0)
    assert measure(firmer, SSM)["hard_brakes_per_100m"] == pytest.approx(100 / 0.09)


def test_energy_is_that_of_rolling_and_of_changes_of_speed() -> None:
    rolling = measure(episode(), SSM)["energy_jpm"]
    assert rolling == pytest.approx(34.0 * 0.015 * 9.81)
    row = measure(episode(speed_mps=np.array([0.0, 0.1, 0.1, 0.1, 0.1])), SSM)
    assert row["energy_jpm"] == pytest.approx(rolling + 34.0 * 1.0 * 0.1 * 0.1 / 0.04)


def test_energy_of_a_contact_is_that_of_the_robot_at_its_relative_speed() -> None:
    touched = episode(outcome="contact_person", contact_speed_mps=1.5)
    assert measure(touched, SSM)["contact_energy_j"] == pytest.approx(0.5 * 34.0 * 1.5**2)
