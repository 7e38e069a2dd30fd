from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import People, Tracker
from hazbot_gym.core.geometry import path_length, route_pose, sample_path
from hazbot_gym.core.jit import kernel
from hazbot_gym.core.patterns import Thresholds, classify
from hazbot_gym.core.state import (
    ACROSS,
    AGAINST,
    ALONG,
    GONE,
    NO_PATTERN,
    PATTERN_NAMES,
    PERSON,
    PERSON_RADIUS_M,
    PRESENT,
    ROBOT_RADIUS_M,
    SCRIPTED,
    SOCIAL_FORCE,
    WAITING,
    Floats,
    Place,
    Records,
    as_record,
    records,
)
from hazbot_gym.sim.walking import lane_point
from hazbot_gym.task.crowd import ROBOT_ROOM_M, START_ROOM_M, crowd_of, draw_people
from hazbot_gym.task.place_data import PathData, PlaceData, RouteData, build_place
from hazbot_gym.task.places import PLACES, load_place
from tests.refusals import refused

NOMINAL_MPS = 0.5
DT_S = 0.1
DRAWS = 300
STRAIGHT = ("open", "corridor", "intersection")  # without corners or bottlenecks
LABEL_M = 3.6  # from where on people are given their pattern
THRESHOLDS = Thresholds(moving_mps=Tracker().moving_mps)


@kernel
def walk(people: Records, routes: Floats, times: Floats, out: Floats) -> None:
    """Write where the first person is if it follows its lane, NaN before it enters; out: (T, 2)."""
    me = people[0]
    for k in range(times.shape[0]):
        walked = me.desired_speed * (times[k] - me.enters_s)
        x, y = lane_point(routes, me, me.s + walked)
        out[k, 0] = x if walked >= 0.0 else np.nan
        out[k, 1] = y if walked >= 0.0 else np.nan


@kernel
def draw(people: Records, place: Place, crowds: Records, shares: Floats, key: np.uint64) -> None:
    draw_people(people, place, crowds[0], shares, key)


def sampler(place: Place, **section: Any) -> Callable[[int], Records]:
    """Return a sampler of the people of a key in a place, under a config's section ``people``."""
    config = People.model_validate(section)
    crowd = as_record(crowd_of(config, place, NOMINAL_MPS))
    shares = np.cumsum(config.reaction_shares) / sum(config.reaction_shares)

    def people_of(key: int) -> Records:
        people = records(PERSON, config.count[1])
        draw(people, place, crowd, shares, np.uint64(key))
        return people

    return people_of


def robot_at(place: Place, speed_mps: float, times: Floats) -> Floats:
    """Return x, y, heading of a robot at constant speed that stops at the path's end, (T, 3)."""
    length = path_length(place.path.view(np.recarray))
    return sample_path(place.path, np.minimum(speed_mps * times, length))[:, :3]


def lanes(place: Place, draws: int = DRAWS, **people: Any) -> tuple[Floats, Floats]:
    """Return times (T,) and where each draw's only person would walk undisturbed, (draws, T, 2)."""
    times = np.arange(0.0, path_length(place.path.view(np.recarray)) / NOMINAL_MPS, DT_S)
    people_of = sampler(place, count=(1, 1), **people)
    tracks = np.empty((draws, len(times), 2))
    for key in range(draws):
        walk(people_of(key), place.routes, times, tracks[key])
    return times, tracks


def families(place: Place) -> list[str]:
    has_crossing = (place.route_kinds == ACROSS).any()
    return [name for name in PATTERN_NAMES if has_crossing or name != "crossing"]


def test_same_key_gives_the_same_people_and_another_key_others() -> None:
    people_of = sampler(load_place("corridor"), count=(3, 3))

    assert people_of(7).tobytes() == people_of(7).tobytes()
    assert len({people_of(key)["y"].tobytes() for key in range(100)}) == 100
    assert people_of(2**63 - 1)["radius"].tolist() == [PERSON_RADIUS_M] * 3


@pytest.mark.parametrize("model", ["scripted", "social_force"])
def test_people_are_as_many_as_fast_and_of_the_kind_that_is_asked_for(model: str) -> None:
    place = load_place("corridor")
    people_of = sampler(place, model=model, count=(1, 4))
    crowds = [people_of(key) for key in range(DRAWS)]
    people = np.concatenate([crowd[crowd["status"] != GONE] for crowd in crowds])

    counts = np.array([np.sum(crowd["status"] != GONE) for crowd in crowds])
    assert np.bincount(counts, minlength=5)[1:].min() > DRAWS / 4 * 0.7
    assert set(counts) == {1, 2, 3, 4}
    assert set(people["model"]) == {SCRIPTED if model == "scripted" else SOCIAL_FORCE}
    is_leader = place.route_kinds[people["route"]] == ALONG
    others = people["desired_speed"][~is_leader]
    assert others.mean() == pytest.approx(1.34, abs=0.03)
    assert others.std() == pytest.approx(0.26, abs=0.03)
    leaders = people["desired_speed"][is_leader]
    assert leaders.min() >= 0.15
    assert leaders.max() <= 0.45
    assert leaders.mean() == pytest.approx(0.3, abs=0.03)


def test_patterns_and_reactions_come_in_the_shares_of_the_config() -> None:
    place = load_place("intersection")
    people_of = sampler(place, count=(1, 1), mix=(1, 0, 3, 0), reaction_shares=(2, 1, 1, 0))
    people = np.concatenate([people_of(key) for key in range(4 * DRAWS)])

    kinds = place.route_kinds[people["route"]]
    assert np.mean(kinds == ACROSS) == pytest.approx(0.25, abs=0.05)
    assert np.mean(kinds == ALONG) == pytest.approx(0.75, abs=0.05)
    routes = people["route"][kinds == ACROSS]
    assert np.mean(routes == 2) == pytest.approx(0.5, abs=0.1), "both sides alike"
    reactions = np.bincount(people["reaction"], minlength=4) / len(people)
    assert reactions == pytest.approx([0.5, 0.25, 0.25, 0.0], abs=0.05)


@pytest.mark.parametrize("name", STRAIGHT)
@pytest.mark.parametrize("model", ["scripted", "social_force"])
def test_first_person_has_the_pattern_of_the_family(name: str, model: str) -> None:
    place = load_place(name)
    for family in families(place):
        times, tracks = lanes(place, family=family, model=model)
        robot = robot_at(place, NOMINAL_MPS, times)
        labels = [_label(track, robot) for track in tracks]

        asked = PATTERN_NAMES.index(family)
        # Who crosses early is already past when the robot comes near.
        assert set(labels) <= {asked, NO_PATTERN}, family
        assert np.mean(np.array(labels) == asked) > (0.75 if family == "crossing" else 0.98)


def _label(track: Floats, robot: Floats) -> int:
    """Return the pattern that the tracker would give, from the first moment in social space on."""
    distance = np.hypot(*(track - robot[:, :2]).T)
    near = np.flatnonzero(distance[:-1] <= LABEL_M)
    if not len(near):
        return NO_PATTERN
    k = near[0]
    velocity = (track[k + 1] - track[k]) / DT_S
    return classify(*(track[k] - robot[k, :2]), robot[k, 2], NOMINAL_MPS, *velocity, THRESHOLDS)


@pytest.mark.parametrize("name", PLACES)
def test_people_are_met_on_the_way(name: str) -> None:
    place = load_place(name)
    for family in families(place):
        times, tracks = lanes(place, family=family, model="scripted")
        robot = robot_at(place, NOMINAL_MPS, times)
        nearest = np.nanmin(np.hypot(*np.moveaxis(tracks - robot[:, :2], -1, 0)), axis=1)

        assert np.mean(nearest < 2.0) >= 0.9, family


@pytest.mark.parametrize("name", PLACES)
@pytest.mark.parametrize("model", ["scripted", "social_force"])
def test_nobody_comes_in_on_top_of_the_robot_or_of_another(name: str, model: str) -> None:
    place = load_place(name)
    people_of = sampler(place, count=(6, 6), model=model)
    for key in range(DRAWS):
        people = people_of(key)
        robot = robot_at(place, NOMINAL_MPS, people["enters_s"])
        here = np.stack([people["x"], people["y"]], axis=1)
        assert np.hypot(*(here - robot[:, :2]).T).min() >= ROBOT_ROOM_M

        here = here[people["status"] == PRESENT]
        apart = np.hypot(*np.moveaxis(here[:, None] - here, -1, 0))
        assert apart[np.triu_indices(len(here), 1)].min(initial=np.inf) >= START_ROOM_M


def test_who_comes_in_beside_the_path_does_so_when_a_nominal_robot_is_elsewhere() -> None:
    path = PathData(points=[(0.0, 0.0), (12.0, 0.0)])
    route = RouteData(points=[(6.0, -1.0), (6.0, 4.0)])
    place = build_place(PlaceData(name="hatch", path=path, routes=[route]))
    people_of = sampler(place, count=(1, 1), family="crossing", model="scripted")
    people = np.concatenate([people_of(key) for key in range(DRAWS)])
    robot = robot_at(place, NOMINAL_MPS, people["enters_s"])

    assert np.hypot(people["x"] - robot[:, 0], people["y"] - robot[:, 1]).min() >= ROBOT_ROOM_M
    assert np.median(people["enters_s"]) > 5.0


def test_people_without_room_queue_where_their_route_begins() -> None:
    people_of = sampler(load_place("corridor"), count=(64, 64), mix=(0, 0, 1, 0))  # leaders only
    people = people_of(0)
    queue = people[people["status"] == WAITING]

    assert np.sum(people["status"] == PRESENT) <= 4, "there are 3.5 m for them"
    assert len(queue) >= 60
    assert (queue["s"] == 0.0).all()
    behind_m = np.sort(queue["enters_s"] * queue["desired_speed"])
    assert np.diff(behind_m).min() > 0.99


def test_who_is_present_is_on_its_lane_and_walks_along_it() -> None:
    place = load_place("aisle")
    people_of = sampler(place, count=(4, 4), model="scripted")
    for key in range(50):
        for person in people_of(key).view(np.recarray):
            x, y, tx, ty = route_pose(place.routes, person.route, person.s)
            assert person.x == pytest.approx(x - person.offset * ty)
            assert person.y == pytest.approx(y + person.offset * tx)
            velocity = (person.desired_speed * tx, person.desired_speed * ty)
            assert (person.vx, person.vy) == pytest.approx(velocity)
            assert abs(person.offset) <= place.route_rooms[person.route]
            assert abs(person.sidestep_offset) <= place.route_rooms[person.route]


@pytest.mark.parametrize("name", [*STRAIGHT, "aisle"])
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_scripted_people_who_come_the_other_way_leave_any_robot_alone(
    name: str, share: float
) -> None:
    place = load_place(name)
    for family in ("encountering", "confronting"):
        times, tracks = lanes(place, family=family, model="scripted")
        robot = robot_at(place, share * NOMINAL_MPS, times)
        nearest = np.nanmin(np.hypot(*np.moveaxis(tracks - robot[:, :2], -1, 0)))

        assert nearest > ROBOT_RADIUS_M + PERSON_RADIUS_M


def test_people_who_come_head_on_without_a_script_stay_in_the_robots_way() -> None:
    people_of = sampler(load_place("corridor"), family="confronting", count=(1, 1))
    people = np.concatenate([people_of(key) for key in range(100)])

    assert np.abs(people["offset"]).max() <= 0.15
    assert (people["sidestep_offset"] == people["offset"]).all()
    assert (load_place("corridor").route_kinds[people["route"]] == AGAINST).all()


def test_crossing_without_a_route_across_is_refused() -> None:
    place = load_place("doorway")

    with refused("people.family ... 'crossing'"):
        sampler(place, family="crossing")
    with refused("people.mix ... crossing"):
        sampler(place, mix=(1, 0, 0, 0))
    routes = sampler(place, count=(64, 64), mix=(9, 1, 1, 1))(0)["route"]
    assert set(place.route_kinds[routes]) == {ALONG, AGAINST}
