"""Reference engine: robot, people and walls as pymunk bodies in one space.

Where something is within the robot's reach, pymunk (Chipmunk 7) integrates the bodies and finds the
contacts; velocities come from the same formulas as in the batched engine (``drive``, ``people``).
Elsewhere no contact is possible, and only the records advance; the bodies are moved to the records'
positions when something comes near. A contact ends the episode. One space serves all episodes:
bodies are moved, not rebuilt; walls are replaced only when the place changes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pymunk

from hazbot_gym.config import Config
from hazbot_gym.core.fuzzy_pid import gain_table
from hazbot_gym.core.jit import LANES, lean_kernel
from hazbot_gym.core.own_walking import address_of_model
from hazbot_gym.core.recorded_table import Stretch
from hazbot_gym.core.state import (
    GAS,
    PERSON_MASS_KG,
    PERSON_RADIUS_M,
    PRESENT,
    ROBOT,
    ROBOT_MASS_KG,
    ROBOT_RADIUS_M,
    WHEEL,
    Floats,
    Ints,
    Place,
    Records,
    as_record,
    records,
)
from hazbot_gym.sim.contact import slack
from hazbot_gym.sim.drive import (
    command_kernel,
    drive,
    drive_parameters,
    free_time_s,
    place_kernel,
)
from hazbot_gym.sim.lanes import DRIVE_LANES
from hazbot_gym.sim.people import move_people, social_step
from hazbot_gym.sim.walkers import Workspace, make_workspace

_ROBOT, _PERSON, _WALL = 1, 2, 3  # collision types
_AWAY = 1.0e6  # parking position of absent people's bodies [m]

# The setter directly: attribute assignment in pymunk checks names, at twice the cost.
_set_velocity = vars(pymunk.Body)["velocity"].fset


class Snapshot(NamedTuple):
    """Copy of the true state at one instant."""

    time_s: float
    x: float
    y: float
    theta: float
    speed_mps: float  # actual, along the heading
    command_mps: float
    s_m: float  # reference point's arc length along the path
    x_e: float
    y_e: float
    theta_e: float
    people: Records  # PERSON records of present people
    persons: Ints  # their indices
    gas: Records = records(GAS, 0)  # (1,) GAS with gas


class Contact(NamedTuple):
    """The first contact of an episode: index of the person, or -1 for a wall."""

    person: int


@lean_kernel
def _walk(
    people: Records,
    robots: Records,
    place: Place,
    force: Records,
    reactions: Records,
    own_model: int,
    recording: Stretch,
    key: np.uint64,
    step: int,
    dt_s: float,
    work: Workspace,
) -> float:
    """Move the people, update their velocities, and return the robot's slack [m]."""
    if step > 0:
        move_people(people, dt_s)
    social_step(
        people, place, robots[0], force[0], reactions, own_model, recording, np.uint64(key), step,
        dt_s, work,
    )  # fmt: skip
    return slack(people, place.walls, robots[0], dt_s)


@lean_kernel
def _advance_freely(
    robots: Records,
    wheels: Records,
    people: Records,
    place: Place,
    parameters: Records,
    gains: Floats,
    force: Records,
    reactions: Records,
    own_model: int,
    recording: Stretch,
    key: np.uint64,
    first: int,
    last: int,
    substeps: int,
    social_s: float,
    slack_m: float,
    lanes: Records,
    work: Workspace,
) -> tuple[int, float]:
    """Simulate social periods from ``first`` on, while no contact is possible.

    Returns:
        The period that is next, ``last`` if all were simulated; and the robot's slack [m].
    """
    period = first
    while period < last and slack_m > 0.0:
        drive(
            robots, wheels, place.path, parameters, gains, key, period * substeps, substeps, lanes
        )
        slack_m = _walk(
            people, robots, place, force, reactions, own_model, recording, key, period + 1,
            social_s, work,
        )  # fmt: skip
        period += 1
    return period, slack_m


class World:
    """A robot, people and walls, stepped one decision at a time.

    Attributes:
        robots: (1,) ROBOT record.
        people: (P,) PERSON records.
        place: Walls, path and routes.
        decision: Number of decisions taken since the reset.
        contact: The first contact, or None.
    """

    people: Records
    place: Place
    contact: Contact | None

    def __init__(self, config: Config) -> None:
        self._clock, self._drive_config = config.clock, config.drive
        self._parameters = as_record(drive_parameters(config.drive, config.clock.physics_s))
        self._gains = gain_table(config.drive.tables)
        self._force = as_record(config.people.force)
        self._reactions = np.concatenate([as_record(r) for r in config.people.reactions])
        self._own_model = address_of_model(config.people.model)
        self._tolerance_m = config.arrival_tolerance_m
        self.robots, self._wheels = records(ROBOT, 1), records(WHEEL, 2)
        self._lanes, self._workspace = records(DRIVE_LANES, 1), make_workspace(0)
        self._pending = np.zeros(config.drive.latency_steps + 1)
        self._slack_m = 0.0  # distance to spare in the next social period
        self._x, self._y = self.robots["x"], self.robots["y"]
        self._space = pymunk.Space()
        for kind in (_PERSON, _WALL):
            self._space.on_collision(_ROBOT, kind, pre_solve=self._on_contact)
        self._robot_body = self._add_body(ROBOT_RADIUS_M, ROBOT_MASS_KG, _ROBOT)
        self._person_bodies: list[pymunk.Body] = []
        self._wall_shapes: list[pymunk.Segment] = []
        self._index: dict[pymunk.Body | None, int] = {}

    def reset(self, place: Place, people: Records, recording: Stretch, key: int) -> None:
        """Start an episode.

        Args:
            place: Walls, path and routes.
            people: (P,) PERSON records at time zero, owned by the world.
            recording: For replayed people.
            key: Key of the scenario's noise.
        """
        if not self._wall_shapes or place.walls is not self.place.walls:
            self._build_walls(place)
        self.place, self.people, self._recording = place, people, recording
        self._make_room()
        self._key, self.decision, self.contact = np.uint64(key), 0, None
        self._pending[:] = self._drive_config.start_speed_mps
        place_kernel(
            self.robots,
            self._wheels,
            place.path,
            self._drive_config.start_speed_mps,
            self._parameters,
            self._gains,
        )
        for i, body in enumerate(self._person_bodies):
            self._park(i, body)
        self._walk(0)

    @property
    def time_s(self) -> float:
        """Time since the reset [s]."""
        return round(self.decision * self._clock.decision_s, 9)

    def free_time_s(self) -> float:
        """Return the travel time of the path at full speed without people [s]."""
        return free_time_s(
            self.place.path,
            self._parameters,
            self._gains,
            self._drive_config.start_speed_mps,
            self._tolerance_m,
        )

    def command(self, speed_mps: float, *, stops: bool = False) -> None:
        """Command a speed for the next decision, or a stop by reflex."""
        command_kernel(self.robots, speed_mps, stops, self._pending, self.decision)

    def advance(self) -> None:
        """Drive and walk for one decision period; stop early at a contact.

        Social periods without possible contact are simulated at once, in compiled code; in the
        others pymunk looks for contacts at every physics step.
        """
        periods = self._clock.social_per_decision
        period, end = self.decision * periods, (self.decision + 1) * periods
        while period < end and self.contact is None:
            if self._slack_m > 0.0:
                period = self._advance_freely(period, end)
            else:
                self._advance_near(period)
                period += 1
        self.decision += 1

    def add_person(self, person: Records) -> int:
        """Add a person (1,) between two decisions, and return its index."""
        self.people = np.concatenate([self.people, person])
        self._make_room()
        self.disturb()
        return len(self.people) - 1

    def disturb(self) -> None:
        """Look for contacts from now on, because people were changed from outside."""
        self._slack_m = 0.0

    def snapshot(self) -> Snapshot:
        """Return a copy of the true state."""
        robot = self.robots[0]
        return Snapshot(
            time_s=self.time_s,
            x=float(robot["x"]),
            y=float(robot["y"]),
            theta=float(robot["theta"]),
            speed_mps=float(robot["v"]),
            command_mps=float(robot["command"]),
            s_m=float(robot["s"]),
            x_e=float(robot["x_e"]),
            y_e=float(robot["y_e"]),
            theta_e=float(robot["theta_e"]),
            people=self.people[self.people["status"] == PRESENT],
            persons=np.flatnonzero(self.people["status"] == PRESENT),
        )

    # --- inside ----------------------------------------------------------------------------------

    def __setstate__(self, state: dict[str, object]) -> None:
        """Restore a copied or pickled world, and recreate its array views."""
        self.__dict__.update(state)
        self._x, self._y = self.robots["x"], self.robots["y"]

    def _make_room(self) -> None:
        """Make the workspace and the bodies that all people need."""
        people = len(self.people)
        if people > LANES * len(self._workspace.walkers):
            self._workspace = make_workspace(people)
        while len(self._person_bodies) < people:
            body = self._add_body(PERSON_RADIUS_M, PERSON_MASS_KG, _PERSON)
            self._index[body] = len(self._person_bodies)
            self._person_bodies.append(body)

    def _advance_freely(self, first: int, last: int) -> int:
        """Simulate social periods while no contact is possible, and return the next one."""
        period, self._slack_m = _advance_freely(
            self.robots,
            self._wheels,
            self.people,
            self.place,
            self._parameters,
            self._gains,
            self._force,
            self._reactions,
            self._own_model,
            self._recording,
            self._key,
            first,
            last,
            self._clock.physics_per_social,
            self._clock.social_s,
            self._slack_m,
            self._lanes,
            self._workspace,
        )
        return period

    def _advance_near(self, period: int) -> None:
        """Simulate a social period with pymunk, up to a contact."""
        self._place_bodies()
        substeps = self._clock.physics_per_social
        for k in range(substeps):
            self._drive(period * substeps + k)
            if self.contact is not None:
                self._catch_up(k + 1)
                return
        self._walk(period + 1)

    def _drive(self, step: int) -> None:
        """Drive the robot for a physics step, and move all bodies with pymunk."""
        x, y = self._x[0], self._y[0]
        drive(
            self.robots,
            self._wheels,
            self.place.path,
            self._parameters,
            self._gains,
            self._key,
            step,
            1,
            self._lanes,
        )
        dt_s = self._clock.physics_s
        _set_velocity(self._robot_body, ((self._x[0] - x) / dt_s, (self._y[0] - y) / dt_s))
        self._space.step(dt_s)

    def _walk(self, step: int) -> None:
        """Move all people, and update their velocities for the next social period."""
        self._slack_m = _walk(
            self.people,
            self.robots,
            self.place,
            self._force,
            self._reactions,
            self._own_model,
            self._recording,
            self._key,
            step,
            self._clock.social_s,
            self._workspace,
        )

    def _place_bodies(self) -> None:
        """Set positions and velocities of all bodies to those of their records."""
        people = self.people
        self._robot_body.position = self._x[0], self._y[0]
        xs, ys = people["x"].tolist(), people["y"].tolist()
        vxs, vys = people["vx"].tolist(), people["vy"].tolist()
        for i, status in enumerate(people["status"].tolist()):
            body = self._person_bodies[i]
            if status == PRESENT:
                body.position = xs[i], ys[i]
                _set_velocity(body, (vxs[i], vys[i]))
            else:
                self._park(i, body)

    def _catch_up(self, physics_steps: int) -> None:
        """Advance the people's records to the time of a contact within a social period."""
        elapsed_s = physics_steps * self._clock.physics_s
        present = self.people["status"] == PRESENT
        for axis in ("x", "y"):
            self.people[axis][present] += self.people[f"v{axis}"][present] * elapsed_s

    def _on_contact(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        """Record the first contact; in a tie, the person of the lowest index."""
        other = next(s for s in arbiter.shapes if s.collision_type != _ROBOT)
        person = self._index[other.body] if other.collision_type == _PERSON else -1
        known = math.inf if self.contact is None or self.contact.person < 0 else self.contact.person
        if self.contact is None or 0 <= person < known:
            self.contact = Contact(person)

    def _add_body(self, radius_m: float, mass_kg: float, kind: int) -> pymunk.Body:
        """Add a disc to the space; people collide with the robot only, not with each other."""
        body = pymunk.Body(mass_kg, pymunk.moment_for_circle(mass_kg, 0.0, radius_m))
        shape = pymunk.Circle(body, radius_m)
        shape.collision_type = kind
        if kind == _PERSON:
            shape.filter = pymunk.ShapeFilter(categories=0b10, mask=0b01)
        else:
            shape.filter = pymunk.ShapeFilter(categories=0b01)
        self._space.add(body, shape)
        return body

    def _park(self, i: int, body: pymunk.Body) -> None:
        body.position = _AWAY + 10.0 * i, _AWAY
        body.velocity = 0.0, 0.0

    def _build_walls(self, place: Place) -> None:
        self._space.remove(*self._wall_shapes)
        static = self._space.static_body
        self._wall_shapes = [
            pymunk.Segment(static, (x1, y1), (x2, y2), 0.0) for x1, y1, x2, y2 in place.walls
        ]
        for shape in self._wall_shapes:
            shape.collision_type = _WALL
            shape.filter = pymunk.ShapeFilter(categories=0b100)
        self._space.add(*self._wall_shapes)
