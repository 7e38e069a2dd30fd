from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.core.jit import kernel
from hazbot_gym.core.place_table import PlaceTable, stack_places
from hazbot_gym.core.recorded_table import RecordedTable, rows_from, stretch_of
from hazbot_gym.core.state import (
    GONE,
    PERSON,
    REPLAY,
    SOCIAL_FORCE,
    WAITING,
    Floats,
    Ints,
    Place,
    Records,
    records,
)
from hazbot_gym.task.recorded import (
    START_ROOM_M,
    draw_stretch,
    fill_replayed,
    fill_seeded,
    load_recordings,
    most_at_once,
    recorded_places,
    recorded_table,
)
from hazbot_gym.task.synthetic_tracks import synthetic_recording
from hazbot_gym.task.tracks import Corridor, Recording, resample, steps_on_clock
from tests.refusals import refused

DT_S = 0.05
KEYS = 200
SHARES = np.array([0.5, 1.0, 1.0, 1.0])


@kernel
def stretches(table: RecordedTable, places: PlaceTable, speed_mps: float, out: Ints) -> None:
    for key in range(out.shape[0]):
        out[key, 0], out[key, 1] = draw_stretch(table, places, np.uint64(key), speed_mps)


@kernel
def seed(people: Records, place: Place, start_s: float, key: np.uint64) -> None:
    fill_seeded(people, place, start_s, SHARES, key)


def walking(*tracks: Floats, first_steps: list[int] | None = None) -> Recording:
    """Return people who walk freely, one position every 0.1 s."""
    return Recording(
        name="few",
        dt_s=0.1,
        ids=np.arange(len(tracks)),
        first_steps=np.array(first_steps or [0] * len(tracks)),
        lengths=np.array([len(track) for track in tracks]),
        positions=np.concatenate(tracks),
    )


def straight(x1: float, x2: float, y: float = 0.0, steps: int = 100) -> Floats:
    return np.column_stack([np.linspace(x1, x2, steps), np.full(steps, y)])


def drawn(recordings: list[Recording], speed_mps: float = 0.5) -> tuple[RecordedTable, Ints]:
    """Return the recordings' table, and the place and step of the first keys (KEYS, 2)."""
    table = recorded_table(recordings, DT_S)
    out = np.zeros((KEYS, 2), np.int64)
    stretches(table, stack_places(recorded_places(recordings, with_entries=False)), speed_mps, out)
    return table, out


def positions_at(table: RecordedTable, which: int, step: int) -> list[Floats]:
    """Return people's positions at a step of a recording, slot by slot; NaN where one is empty."""
    stretch = stretch_of(table, int(table.ways[which, 0]), step)
    rows = [rows_from(stretch, slot, 0) for slot in range(len(stretch.slots) - 1)]
    return [table.positions[row] if row < end else np.full(2, np.nan) for row, end in rows]


def sets_at_each_step(table: RecordedTable, which: int) -> list[set[tuple[float, float]]]:
    steps = [positions_at(table, which, step) for step in range(table.counts[which])]
    return [{(x, y) for x, y in row if not np.isnan(x)} for row in steps]


def expected_at_each_step(recording: Recording) -> list[set[tuple[float, float]]]:
    sampled = resample(recording, DT_S)
    sets: list[set[tuple[float, float]]] = [set() for _ in range(steps_on_clock(recording, DT_S))]
    for first, track in zip(sampled.first_steps, sampled.tracks(), strict=True):
        for step, (x, y) in enumerate(track.tolist(), first):
            sets[step].add((x, y))
    return sets


def test_table_holds_everybody_at_every_step_in_fewer_slots() -> None:
    recording = synthetic_recording()
    table = recorded_table([recording, recording], DT_S)
    expected = expected_at_each_step(recording)

    assert table.counts.tolist() == [len(expected)] * 2
    assert sets_at_each_step(table, 0) == sets_at_each_step(table, 1) == expected
    assert np.array_equal(*np.split(table.positions, 2))
    assert table.slots.shape[1] - 1 < recording.people / 2


def test_recordings_of_unlike_size_share_a_table() -> None:
    few = walking(straight(0, 9), straight(9, 0, 2.0), first_steps=[0, 30])
    many = synthetic_recording()
    table = recorded_table([few, many], DT_S)

    assert sets_at_each_step(table, 0) == expected_at_each_step(few)
    assert sets_at_each_step(table, 1) == expected_at_each_step(many)


def test_table_holds_the_sightings_and_no_empty_slots() -> None:
    # Two people meet once in an hour: times x slots would be a thousand times their sightings.
    tracks = [straight(0, 9), straight(0, 9, 1.0), straight(0, 9)]
    table = recorded_table([walking(*tracks, first_steps=[0, 20, 35900])], DT_S)

    assert table.counts.tolist() == [71999]
    assert len(table.positions) == 3 * 199


def test_slot_is_empty_for_two_decisions_before_the_next_person_takes_it() -> None:
    # The second comes 0.2 s after the first has gone, too soon for its slot; the third does not.
    recording = walking(
        straight(0, 9), straight(9, 0), straight(0, 9, 1.0), first_steps=[0, 101, 103]
    )
    table = recorded_table([recording], DT_S)
    first_slot = np.array([positions_at(table, 0, step)[0] for step in range(table.counts[0])])

    assert table.slots.tolist() == [[0, 2, 3]]
    is_there = ~np.isnan(first_slot[:, 0])
    gap = np.flatnonzero(is_there[1:] & ~is_there[:-1]) - np.flatnonzero(
        is_there[:-1] & ~is_there[1:]
    )
    assert gap.tolist() == [7]
    assert first_slot[-1].tolist() == pytest.approx([9.0, 1.0])


def test_stretches_go_both_ways_through_all_recordings() -> None:
    recordings = [synthetic_recording(0), synthetic_recording(1)]
    table, out = drawn(recordings)
    places, steps = out.T

    assert np.bincount(places, minlength=4).min() > KEYS / 4 * 0.6
    which = places // 2
    needed = 2.0 * 12.0 / 0.5 / DT_S
    assert (steps >= 0).all()
    assert (steps <= np.maximum(table.counts[which] - needed, 0)).all()
    assert len(np.unique(steps)) > KEYS / 4


def test_robot_starts_where_nobody_stands() -> None:
    recordings = [synthetic_recording(0)]
    table, out = drawn(recordings, speed_mps=5.0)  # leaves most of the recording to choose from
    starts = np.array([[0.0, 0.0], [12.0, 0.0]])

    positions = np.array([positions_at(table, 0, step) for step in range(table.counts[0])])
    apart = positions[out[:, 1]] - starts[out[:, 0]][:, None]
    nearest = np.nanmin(np.hypot(*np.moveaxis(apart, -1, 0)), axis=1, initial=np.inf)
    blind = positions[:, None] - starts[:, None]
    is_taken = np.nanmin(np.hypot(*np.moveaxis(blind, -1, 0)), axis=2, initial=np.inf)
    assert np.mean(is_taken < START_ROOM_M) > 0.05, "one would start blindly in somebody's way"
    assert nearest.min() >= START_ROOM_M


def test_recording_shorter_than_the_drive_is_replayed_from_its_beginning() -> None:
    recording = walking(straight(0, 9), straight(9, 0, 2.0))
    _, out = drawn([recording])

    assert set(out[:, 1]) == {0}


def test_way_through_a_corridor_has_its_walls_and_runs_in_both_directions() -> None:
    there, back = recorded_places([synthetic_recording()], with_entries=False)

    assert there.path["heading"].tolist() == [0.0]
    assert abs(back.path["heading"][0]) == pytest.approx(np.pi)
    assert np.array_equal(there.walls, back.walls)
    assert len(there.walls) == 2


def test_replayed_people_wait_for_their_slots() -> None:
    people = records(PERSON, 3)
    fill_replayed(people.view(np.recarray))

    assert people["model"].tolist() == [REPLAY] * 3
    assert people["status"].tolist() == [WAITING] * 3
    assert people["route"].tolist() == [0, 1, 2]


def test_seeded_people_come_in_as_recorded_from_the_moment_on() -> None:
    recording = walking(
        straight(0, 9),  # came before
        straight(9, 0, 1.0),
        straight(0, 12, 2.0),
        first_steps=[0, 30, 80],
    )
    place = recorded_places([recording], with_entries=True)[0]
    people = records(PERSON, 4)
    seed(people, place, 1.0, np.uint64(7))

    assert people["status"].tolist() == [WAITING, WAITING, GONE, GONE]
    assert people["enters_s"][:2] == pytest.approx([2.0, 7.0])
    assert people["desired_speed"][:2] == pytest.approx([9.0 / 9.9, 12.0 / 9.9], rel=1e-3)
    assert set(people["model"][:2]) == {SOCIAL_FORCE}
    for person in people[:2]:
        route = place.routes[person["route"]]
        assert (person["x"], person["y"]) == tuple(route[0, :2])
    ends = [place.routes[route][-1, :2].tolist() for route in people["route"][:2]]
    assert ends == [[0.0, 1.0], [12.0, 2.0]]


def test_seeded_peoples_reactions_are_drawn_by_the_key() -> None:
    place = recorded_places([synthetic_recording()], with_entries=True)[0]
    crowds = []
    for key in range(40):
        people = records(PERSON, 20)
        seed(people, place, 0.0, np.uint64(key))
        crowds.append(people["reaction"])

    assert np.bincount(np.concatenate(crowds)) / 800 == pytest.approx([0.5, 0.5], abs=0.06)
    assert not np.array_equal(crowds[0], crowds[1])


def test_room_is_made_for_those_who_are_there_at_once_and_half_as_many_again() -> None:
    tracks = [straight(0, 9, y) for y in range(5)]  # each takes 9.9 s
    apart = walking(*tracks, first_steps=[0, 200, 400, 600, 800])
    at_once = walking(*tracks, first_steps=[0, 1, 2, 3, 800])
    by_twos = walking(*tracks, first_steps=[0, 50, 200, 250, 400])

    def room(recording: Recording, duration_s: float) -> int:
        return most_at_once(recorded_places([recording], with_entries=True), duration_s)

    assert room(apart, 1000.0) == 2
    assert room(at_once, 1000.0) == 5  # of 6: no more ever come
    assert room(by_twos, 1000.0) == 3
    assert room(at_once, 0.15) == 2  # nobody else comes within the episode


def test_who_returns_to_where_it_came_from_seeds_nobody() -> None:
    there_and_back = np.concatenate([straight(0, 5), straight(5, 0)])
    recording = walking(there_and_back, straight(9, 0, 1.0))
    places = recorded_places([recording], with_entries=True)
    assert [len(place.routes) for place in places] == [1, 1]


def test_seeded_routes_stay_in_the_corridor() -> None:
    recording = replace(
        synthetic_recording(),
        corridor=Corridor("x", (2.0, 10.0), (-1.5, 1.5)),
        walls=np.zeros((0, 4)),
    )
    routes = recorded_places([recording], with_entries=True)[0].routes

    assert routes[:, :, 0].min() >= 2.0
    assert routes[:, :, 0].max() <= 10.0
    assert np.ptp(routes[:, :, 0], axis=1).min() > 7.5


def test_corridor_that_nobody_walks_through_is_refused() -> None:
    recording = replace(synthetic_recording(), corridor=Corridor("x", (90.0, 99.0), (-1.5, 1.5)))

    with refused("tracks ... synthetic ... corridor"):
        recorded_places([recording], with_entries=True)


def test_tracks_that_are_not_there_are_refused(tmp_path: Path) -> None:
    with refused("tracks ... nowhere"):
        load_recordings(str(tmp_path / "nowhere"))
    with refused("tracks ... no recordings"):
        load_recordings(str(tmp_path))


def test_without_tracks_the_package_brings_its_own() -> None:
    assert [recording.name for recording in load_recordings(None)] == ["synthetic"]


@pytest.mark.parametrize("name", ["boa-300-050-070", "zara01"])
def test_real_people_can_be_replayed_and_can_seed_others(tracks_dir: Path, name: str) -> None:
    file = next(tracks_dir.rglob(f"{name}.csv"))
    recordings = load_recordings(str(file))
    table, out = drawn(recordings)
    seeded = recorded_places(recordings, with_entries=True)

    assert [recording.name for recording in recordings] == [name]
    assert sets_at_each_step(table, 0) == expected_at_each_step(recordings[0])
    assert len(np.unique(out[:, 1])) > KEYS / 2
    entered = len(seeded[0].entry_times_s)
    assert 0.8 * recordings[0].people < entered <= recordings[0].people
    assert [len(place.routes) for place in seeded] == [entered, entered]
    assert np.median(seeded[0].entry_speeds_mps) == pytest.approx(1.2, abs=0.2)
