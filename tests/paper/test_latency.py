from __future__ import annotations

import math

from hazbot_gym.paper.sections.control_system.experiment import costliest, families, sweep


def test_a_late_robot_moves_on_near_the_human() -> None:
    found = sweep("E*", seeds=2, steps=(0, 2, 10))
    assert found.delay_s.tolist() == [0.0, 0.2, 1.0]
    assert found.inside_s[0] < 0.1
    assert found.inside_s[0] < found.inside_s[1] < found.inside_s[2]
    assert found.affected_from_s == 0.2


def test_crossing_bears_more_and_then_ends_in_a_touch() -> None:
    found = sweep("C*", seeds=2, steps=(0, 2, 25))
    assert found.inside_s[1] == found.inside_s[0] == 0.0
    assert found.hits.tolist() == [0.0, 0.0, 1.0]
    assert math.isnan(sweep("C*", seeds=2, steps=(0, 2)).affected_from_s)


def test_delay_costs_intrusion_among_people_who_react() -> None:
    rows = [row for row in families(10) if row["family"] == "Encountering"]
    assert rows[-1]["personal_m"] > 1.5 * rows[0]["personal_m"]


def test_a_family_is_compared_with_itself() -> None:
    rows = [
        {"family": family, "delay_s": delay_s, "personal_m": intrusion}
        for family, delay_s, intrusion in (
            ("A", 0.0, 0.1),
            ("A", 1.0, 0.2),
            ("B", 0.0, 0.3),
            ("B", 1.0, 0.9),
        )
    ]
    assert costliest(rows) == (rows[3], rows[2])
