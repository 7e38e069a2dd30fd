"""Scenarios: people that are drawn, specified, replayed, or seeded from tracks.

A table of arrays holds all parameters, and ``draw_scenario`` maps a key to a scenario: equal keys
give equal scenarios, for both engines and all policies.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Config, Walker
from hazbot_gym.core.jit import lean_kernel, routine
from hazbot_gym.core.place_table import PlaceTable, place_at, stack_places
from hazbot_gym.core.recorded_table import NO_RECORDING, RecordedTable, Stretch, stretch_of
from hazbot_gym.core.state import (
    GAS,
    PERSON,
    PERSON_RADIUS_M,
    PRESENT,
    SCRIPTED,
    Floats,
    Place,
    Records,
    as_record,
    records,
)
from hazbot_gym.task.crowd import Crowd, crowd_of, draw_people
from hazbot_gym.task.leak import GasTable, gas_table, leak_of
from hazbot_gym.task.place_doubts import doubt
from hazbot_gym.task.places import is_file, load_place
from hazbot_gym.task.recorded import (
    draw_stretch,
    fill_replayed,
    fill_seeded,
    load_recordings,
    most_at_once,
    recorded_places,
    recorded_table,
)

CROWD, WALKERS, REPLAYED, SEEDED = range(4)
WALKER_REACH_M = 200.0  # length of the routes of specified walkers


class ScenarioTable(NamedTuple):
    """Parameters of the scenario distribution, as arrays for kernels."""

    kind: int  # CROWD, WALKERS, REPLAYED or SEEDED
    places: PlaceTable
    crowd: Records  # (1,) record of ``Crowd``
    walkers: Records  # (P,) PERSON, for WALKERS
    recorded: RecordedTable
    reaction_shares: Floats  # (4,) cumulative
    nominal_speed_mps: float
    gas: GasTable  # of leaks


class Scenario(NamedTuple):
    """Scenario of an episode.

    Attributes:
        name: Name of the place or the recording.
        place: Walls, path and routes.
        people: (P,) PERSON records at time zero.
        recording: Remaining recording to replay; without steps if none.
        gas: (1,) GAS record at time zero; (0,) without gas.
    """

    name: str
    place: Place
    people: Records
    recording: Stretch
    gas: Records = records(GAS, 0)


class ScenarioSampler:
    """Sampler of a config's scenarios.

    Attributes:
        table: Parameters of the distribution.
        people: Number of PERSON records per scenario.
        names: Name of each place of the table.
    """

    def __init__(self, config: Config, *, warns: bool = True) -> None:
        """Build the table.

        Args:
            config: The config.
            warns: Whether to warn of a doubtful place.

        Raises:
            InvalidInput: The place or the tracks cannot be used, or the place lacks a route.
        """
        if config.people.model in ("replay", "seeded"):
            self.table, self.names = _recorded(config)
        else:
            self.table, self.names = _in_place(config, warns)
        self.people = _slots(self.table, config)
        self._places = [place_at(self.table.places, i) for i in range(len(self.names))]

    def draw(self, key: int) -> Scenario:
        """Return the scenario of a key."""
        people = records(PERSON, self.people)
        place, start = _draw(people, self.table, np.uint64(key))
        recording = stretch_of(self.table.recorded, place, start)
        if self.table.kind != REPLAYED:
            recording = recording._replace(steps=0)
        where = self._places[place]
        gas = leak_of(self.table.gas, place, where.path, key)
        return Scenario(self.names[place], where, people, recording, gas)


@routine
def draw_scenario(people: Records, table: ScenarioTable, key: np.uint64) -> tuple[int, int]:
    """Write people (P,) at time zero; return the place, and the first step of its recording.

    The records must be zero before.
    """
    if table.kind == CROWD:
        draw_people(people, place_at(table.places, 0), table.crowd[0], table.reaction_shares, key)
        return 0, 0
    if table.kind == WALKERS:
        for i in range(people.shape[0]):
            people[i] = table.walkers[i]
        return 0, 0
    place, start = draw_stretch(table.recorded, table.places, key, table.nominal_speed_mps)
    if table.kind == REPLAYED:
        fill_replayed(people)
    else:
        start_s = start * table.recorded.dt_s
        seeded = place_at(table.places, place)
        fill_seeded(people, seeded, start_s, table.reaction_shares, key)
    return place, start


@lean_kernel
def _draw(people: Records, table: ScenarioTable, key: np.uint64) -> tuple[int, int]:
    return draw_scenario(people, table, key)


# --- building ------------------------------------------------------------------------------------


def _in_place(config: Config, warns: bool) -> tuple[ScenarioTable, list[str]]:
    place = load_place(config.place, config.place_options)
    walkers = records(PERSON, 0)
    if warns and (config.place_options or is_file(config.place)):
        doubt(f"place {config.place}", place, config)
    if config.people.walkers:
        kind = WALKERS
        crowd = Crowd()
        place, walkers = walkers_on_routes(config.people.walkers, place)
    else:
        kind = CROWD
        crowd = crowd_of(config.people, place, config.drive.nominal_speed_mps)
    table = _table(config, kind, [place])
    return table._replace(crowd=as_record(crowd), walkers=walkers), [Path(config.place).stem]


def _recorded(config: Config) -> tuple[ScenarioTable, list[str]]:
    recordings = load_recordings(config.tracks)
    is_seeded = config.people.model == "seeded"
    places = recorded_places(recordings, with_entries=is_seeded)
    recorded = recorded_table(recordings, config.clock.social_s)
    for recording, (first, _) in zip(recordings, recorded.ways, strict=True):
        if config.tracks:
            doubt(f"tracks: {recording.name}", places[first], config)
    table = _table(config, SEEDED if is_seeded else REPLAYED, places)
    names = [recordings[i].name for i in recorded.recording_of_place]
    return table._replace(recorded=recorded), names


def _table(config: Config, kind: int, places: list[Place]) -> ScenarioTable:
    shares = np.array(config.people.reaction_shares)
    return ScenarioTable(
        kind=kind,
        places=stack_places(places),
        crowd=as_record(Crowd()),
        walkers=records(PERSON, 0),
        recorded=NO_RECORDING,
        reaction_shares=np.cumsum(shares / shares.sum()),
        nominal_speed_mps=config.drive.nominal_speed_mps,
        gas=gas_table(config, places),
    )


def _slots(table: ScenarioTable, config: Config) -> int:
    if table.kind == CROWD:
        return config.people.count[1]
    if table.kind == WALKERS:
        return len(table.walkers)
    if table.kind == REPLAYED:
        return int(table.recorded.slots.shape[1]) - 1
    places = [place_at(table.places, i) for i in range(len(table.places.wall_counts))]
    return most_at_once(places, config.max_episode_steps * config.clock.decision_s)


def walkers_on_routes(walkers: tuple[Walker, ...], place: Place) -> tuple[Place, Records]:
    """Return the place with one straight route for each walker, and the walkers on them."""
    people = records(PERSON, len(walkers))
    routes = np.empty((len(walkers), 2, 3))
    for i, walker in enumerate(walkers):
        start = np.array([walker.x_m, walker.y_m])
        speed = math.hypot(walker.vx_mps, walker.vy_mps)
        along = np.array([walker.vx_mps, walker.vy_mps]) / speed if speed else np.array([1.0, 0.0])
        routes[i] = [[*start, 0.0], [*(start + WALKER_REACH_M * along), WALKER_REACH_M]]
        person = people[i]
        person["route"], person["model"], person["status"] = i, SCRIPTED, PRESENT
        person["x"], person["y"] = start
        person["vx"], person["vy"] = walker.vx_mps, walker.vy_mps
        person["radius"], person["desired_speed"] = PERSON_RADIUS_M, speed
    alike = np.zeros(len(walkers))
    return (
        place._replace(
            routes=routes,
            route_kinds=alike.astype(np.int64),
            route_anchors=np.zeros((len(walkers), 2)),
            route_rooms=alike,
        ),
        people,
    )
