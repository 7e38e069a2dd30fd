from __future__ import annotations

import pytest

from hazbot_gym.runtime.people import Encounters, Person, as_people


def pattern(fields: dict[str, float]) -> str:
    names = ("crossing", "encountering", "leading", "confronting")
    return " ".join(name for name in names if fields[f"person0_{name}"] == 1.0)


def test_a_pattern_is_held_by_the_track_within_the_social_distance() -> None:
    encounters = Encounters(0.5, 3)
    coming = Person(3.0, 0.1, -1.2, 0.0, track="a")
    beside = Person(1.5, 0.1, 0.0, 1.2, track="a")  # has turned to the side

    assert pattern(encounters.fields([coming], 0.5)) == "confronting"
    assert pattern(encounters.fields([beside], 0.5)) == "confronting"
    assert pattern(encounters.fields([beside._replace(track="b")], 0.5)) == "crossing"
    assert pattern(encounters.fields([coming._replace(x_m=4.0)], 0.5)) == ""
    assert pattern(encounters.fields([beside], 0.5)) == "crossing"


@pytest.mark.parametrize("forget", [True, False])
def test_without_a_track_or_after_forgetting_the_pattern_is_new(forget: bool) -> None:
    encounters = Encounters(0.5, 3)
    track = "a" if forget else None
    encounters.fields([Person(3.0, 0.1, -1.2, 0.0, track)], 0.5)
    if forget:
        encounters.forget()
    assert pattern(encounters.fields([Person(1.5, 0.1, 0.0, 1.2, track)], 0.5)) == "crossing"


def test_people_out_of_the_tracker_s_range_are_left_out() -> None:
    fields = Encounters(0.5, 3).fields([Person(8.1, 0.0, -1.0, 0.0)], 0.5)
    assert fields["person0_present"] == 0.0


def test_mappings_are_people_too() -> None:
    given = {"x_m": 1.0, "y_m": 2.0, "vx_mps": 0.0, "vy_mps": 0.0}
    assert as_people([given, (1.0, 2.0, 0.0, 0.0, 7)])[1] == Person(1.0, 2.0, 0.0, 0.0, track=7)
    assert as_people([given]) == [Person(1.0, 2.0, 0.0, 0.0)]
