"""Where an episode's people come from: drawn, given singly, replayed, or seeded from tracks.

A source turns a key into a scenario; the same key gives the same one, whoever drives through it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from hazbot_gym.config import Config, Walker
from hazbot_gym.core.state import (
    PERSON,
    PERSON_RADIUS_M,
    PRESENT,
    SCRIPTED,
    Floats,
    Place,
    Records,
    records,
)
from hazbot_gym.task.crowd import Sampler
from hazbot_gym.task.places import load_place
from hazbot_gym.task.recorded import Recordings, replay, seed_people

NO_RECORDING = np.zeros((0, 0, 2))
WALKER_REACH_M = 200.0  # walkers given one by one walk on this far


class Scenario(NamedTuple):
    """All that is drawn at a reset.

    Attributes:
        name: What the place or the recording is called.
        place: Walls, path and routes.
        people: (P,) PERSON records at time zero.
        recording: (T, P, 2) positions at every social step [m] for replayed people, else (0, 0, 2).
    """

    name: str
    place: Place
    people: Records
    recording: Floats


class Source(Protocol):
    """Draws scenarios."""

    def draw(self, key: int) -> Scenario:
        """Return the scenario of a key."""
        ...


def make_source(config: Config) -> Source:
    """Return the source that a config asks for.

    Raises:
        InvalidInput: The place or the tracks cannot be used, or the place lacks a route.
    """
    if config.people.model in ("replay", "seeded"):
        return RecordedSource(config)
    place = load_place(config.place, config.place_options)
    name = Path(config.place).stem
    if config.people.walkers:
        return WalkerSource(name, place, config.people.walkers)
    return CrowdSource(name, place, config)


class CrowdSource:
    """People drawn at random on the routes of a place."""

    def __init__(self, name: str, place: Place, config: Config) -> None:
        self._name, self._place = name, place
        self._sampler = Sampler(config.people, place, config.drive.nominal_speed_mps)

    def draw(self, key: int) -> Scenario:
        """Return the scenario of a key."""
        return Scenario(self._name, self._place, self._sampler.draw(key), NO_RECORDING)


class WalkerSource:
    """Scripted people given one by one: the same scenario for every key."""

    def __init__(self, name: str, place: Place, walkers: tuple[Walker, ...]) -> None:
        self._name = name
        self._place, self._people = walkers_on_routes(walkers, place)

    def draw(self, key: int) -> Scenario:
        """Return the scenario; the key only tells the noise apart."""
        return Scenario(self._name, self._place, self._people.copy(), NO_RECORDING)


class RecordedSource:
    """Real people, replayed as they walked, or their entries given to social-force walkers."""

    def __init__(self, config: Config) -> None:
        self._recordings = Recordings(config.tracks)
        self._config = config

    def draw(self, key: int) -> Scenario:
        """Return a stretch of one of the recordings, and one of the two ways through it."""
        config = self._config
        horizon_s = config.max_episode_steps * config.clock.decision_s
        stretch = self._recordings.choose(key, config.drive.nominal_speed_mps)
        if config.people.model == "replay":
            people, positions = replay(stretch, horizon_s, config.clock.social_s)
            return Scenario(stretch.recording.name, stretch.place, people, positions)
        people, routes = seed_people(stretch, horizon_s, config.people.reaction_shares, key)
        place = stretch.place._replace(routes=routes)
        return Scenario(stretch.recording.name, place, people, NO_RECORDING)


def walkers_on_routes(walkers: tuple[Walker, ...], place: Place) -> tuple[Place, Records]:
    """Return the place with one straight route for each walker, and the walkers on them."""
    people = records(PERSON, len(walkers))
    routes = np.empty((len(walkers), 2, 3))
    for i, walker in enumerate(walkers):
        start = np.array([walker.x_m, walker.y_m])
        speed = math.hypot(walker.vx_mps, walker.vy_mps)
        velocity = np.array([walker.vx_mps, walker.vy_mps])
        direction = velocity / speed if speed else np.array([1.0, 0.0])
        routes[i] = [[*start, 0.0], [*(start + WALKER_REACH_M * direction), WALKER_REACH_M]]
        person = people[i]
        person["route"], person["model"], person["status"] = i, SCRIPTED, PRESENT
        person["x"], person["y"] = start
        person["vx"], person["vy"] = walker.vx_mps, walker.vy_mps
        person["radius"], person["desired_speed"] = PERSON_RADIUS_M, speed
    return place._replace(routes=routes), people
