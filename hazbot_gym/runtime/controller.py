"""SpeedController: a policy on a robot, from readings by name to a commanded speed."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hazbot_gym.config.parameters import MOST_PEOPLE
from hazbot_gym.core.sensor_ring import RangeSensor, Ring
from hazbot_gym.core.state import PERSON_SLOTS
from hazbot_gym.core.ultrasonic import Ultrasonic
from hazbot_gym.errors import HazbotError, InvalidInput
from hazbot_gym.policies.base import Policy, make
from hazbot_gym.policies.guard import Actions, Observations
from hazbot_gym.policies.made_for import SPEED, needs_of, parts_of, training_config
from hazbot_gym.runtime.people import Encounters, Given, Person
from hazbot_gym.runtime.readings import (
    Readings,
    Stop,
    checked,
    own_names,
    refused_by_policy,
    too_old,
)
from hazbot_gym.runtime.robot_file import Robot, check_agreement, load_robot, simulated_robot
from hazbot_gym.task.action import commanded_speed, level_action
from hazbot_gym.task.observation import (
    TIERS,
    Layout,
    known_layout,
    layout_for,
    observing_layout,
)
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.whole_number import whole_number

STALE_PERIODS = 3.0  # decision periods without readings after which the robot stops
DEAD_BAND_MPS = 0.01  # slower is standing: motors do not turn
_WARM_UP = 12  # decisions, in which every kernel of a policy is called


class SpeedController:
    """A policy that commands a robot's speed; compiled code is loaded at construction.

    Call ``step`` once in each decision period with the newest readings. It never raises for
    readings: where they are missing, not finite, impossible or stale it returns 0, and ``stop``
    tells the reason. A drive that may miss a call polls ``current_mps``, which falls to 0 if
    ``step`` is not called in time. The controller is for one thread.

    Attributes:
        layout: The observation's fields; ``layout.names`` are their names.
        robot: The robot, as given or as simulated.
    """

    def __init__(
        self,
        policy: str | Policy,
        *,
        tier: str = "tracks",
        ring: Ring = "paper",
        has_gas: bool = False,
        person_slots: int = PERSON_SLOTS,
        robot: Robot | Path | str | None = None,
        stale_s: float | None = None,
        dead_band_mps: float = DEAD_BAND_MPS,
        allow_pickle: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Make the policy, check that it is made for the robot, and call it until it is warm.

        Args:
            policy: Its spec, as of ``make_policy``, or an object with ``predict``.
            tier: ``sonar`` without a people tracker, else ``tracks``.
            ring: The ring of range sensors; a robot's own replaces it.
            has_gas: Whether there is a gas sensor.
            person_slots: Number of people that the policy is told of, with a tracker.
            robot: A robot or its YAML file, checked against the policy; None for the simulator's.
            stale_s: Age of readings, and time between two steps, that stops the robot; default
                three decision periods.
            dead_band_mps: Slower commands are 0.
            allow_pickle: Whether a ``learned`` zip may execute its pickled code.
            clock: Monotonic time [s].

        Raises:
            InvalidInput: The policy or the robot cannot be used, or they do not agree.
        """
        if tier not in TIERS:
            raise InvalidInput(f"tier: given {tier!r}, allowed are {', '.join(TIERS)}")
        name = policy if isinstance(policy, str) else type(policy).__name__
        self._policy = (
            make(policy, allow_pickle=allow_pickle) if isinstance(policy, str) else policy
        )
        given = load_robot(robot) if isinstance(robot, str | Path) else robot
        whole_number(person_slots, "person_slots", 1, MOST_PEOPLE)
        self.layout = layout_for(
            tier,
            ring if given is None else given.ring,
            has_gas=has_gas,
            person_slots=person_slots,
        )
        with observing_layout(self.layout):
            needed = robot_for(self._policy, self.layout)
        self.robot = needed if given is None else given
        check_agreement(self.robot, needed, name)
        period_s = self.robot.decision_period_s
        self._stale_s = _positive(
            "stale_s", STALE_PERIODS * period_s if stale_s is None else stale_s
        )
        self._dead_band_mps, self._clock = dead_band_mps, clock
        self._encounters = Encounters(self.robot.nominal_speed_mps, self.layout.person_slots)
        self._warm_up()
        self.reset()

    def reset(self) -> None:
        """Begin a new round: forget the policy's memory, the people and the last command."""
        self._state: object = None
        self._begins = True
        self._command_mps = 0.0
        self._stepped_s: float | None = None
        self._stop: Stop | None = Stop("no readings", "no readings since the reset")
        self._encounters.forget()

    def step(
        self,
        *,
        ranges_m: Sequence[float] | Mapping[str, float] | None = None,
        speed_mps: float | None = None,
        yaw_rate_radps: float | None = None,
        x_e_m: float | None = None,
        y_e_m: float | None = None,
        theta_e_rad: float | None = None,
        remaining_m: float | None = None,
        curvature_ahead_per_m: float | None = None,
        people: Given | None = None,
        gas_reading: float | None = None,
        gas_rate_per_s: float | None = None,
        gas_since_peak_s: float | None = None,
        gas_alarmed: float | None = None,
        gas_history: Sequence[float] = (),
        command_mps: float | None = None,
        age_s: float = 0.0,
    ) -> float:
        """Return the speed to command now [m/s].

        Fields that the tier does not have are not read. The table of the observation
        (``docs/environments.md``) defines them.

        Args:
            ranges_m: Range readings in the order of the ring, or by name; infinity is no echo.
            speed_mps: Linear velocity.
            yaw_rate_radps: Angular velocity.
            x_e_m: Along-track error.
            y_e_m: Cross-track error.
            theta_e_rad: Heading error.
            remaining_m: Path left to go.
            curvature_ahead_per_m: Curvature of the path 1 m ahead.
            people: Tracked people as ``Person`` records or mappings: position relative to the
                robot, velocity over ground, both along its axes; [] if the tracker sees nobody.
            gas_reading: Gas sensor, filtered, in units of the alarm threshold.
            gas_rate_per_s: Its rate.
            gas_since_peak_s: Time since the largest reading so far.
            gas_alarmed: 1 from the first alarm on.
            gas_history: Its readings 1 s, 2 s, ... 10 s ago.
            command_mps: Speed commanded last; default the last answer of this controller.
            age_s: Age of the oldest of these readings.
        """
        fields = {
            "speed_mps": speed_mps,
            "yaw_rate_radps": yaw_rate_radps,
            "command_mps": self._command_mps if command_mps is None else command_mps,
            "x_e_m": x_e_m,
            "y_e_m": y_e_m,
            "theta_e_rad": theta_e_rad,
            "remaining_m": remaining_m,
            "curvature_ahead_per_m": curvature_ahead_per_m,
            "gas_reading": gas_reading,
            "gas_rate_per_s": gas_rate_per_s,
            "gas_since_peak_s": gas_since_peak_s,
            "gas_alarmed": gas_alarmed,
            **{f"gas_reading_{k + 1}s": reading for k, reading in enumerate(gas_history)},
        }
        late = self._late(age_s)
        found = late or checked(self.layout, ranges_m, people, fields, self.robot.nominal_speed_mps)
        answer = found if isinstance(found, Stop) else self._ask(found)
        self._stop = answer if isinstance(answer, Stop) else None
        self._command_mps = 0.0 if isinstance(answer, Stop) else answer
        return self._command_mps

    def current_mps(self) -> float:
        """Return the speed to command between two steps: the last one, or 0 if it is stale."""
        return 0.0 if self.stop is not None else self._command_mps

    @property
    def stop(self) -> Stop | None:
        """Reason for which the watchdog stops the robot now; None while the policy commands."""
        if self._stop is None and self._stepped_s is not None:
            return self._gap(self._clock() - self._stepped_s)
        return self._stop

    def observation(self, found: Readings) -> Observations:
        """Return the observation of readings, as the simulator encodes them."""
        sensors = self.layout.sensors
        ranges = zip(sensors, found.ranges_m, strict=True)
        fields = {f"range_{sensor.name}_m": value for sensor, value in ranges} | found.fields
        if self.layout.has_people:
            fields |= self._encounters.fields(found.people, found.fields["speed_mps"])
        return self.layout.encode(fields)

    def _late(self, age_s: float) -> Stop | None:
        """Return a stop if the readings are old, or come after a gap, which ends a round."""
        now_s = self._clock()
        before_s, self._stepped_s = self._stepped_s, now_s
        gap = None if before_s is None else self._gap(now_s - before_s)
        if gap is not None:
            self._state, self._begins = None, True
            self._encounters.forget()
            return gap
        return too_old(age_s, self._stale_s)

    def _gap(self, since_s: float) -> Stop | None:
        if since_s <= self._stale_s:
            return None
        return Stop("stale", f"no step for {since_s:.3g} s, allowed is {self._stale_s:g} s")

    def _ask(self, found: Readings) -> float | Stop:
        """Return the policy's speed, or a stop if it has no usable answer."""
        starts = np.array([self._begins])
        try:
            with observing_layout(self.layout):
                action, self._state = self._policy.predict(
                    self.observation(found), state=self._state, episode_start=starts
                )
        except HazbotError as error:
            return refused_by_policy(error)
        self._begins = False
        value = _action(action)
        if not -1.0 <= value <= 1.0 + 1e-6:  # NaN is neither
            return Stop("policy", f"the policy answers {value:g}, allowed is -1 to 1")
        speed_mps = commanded_speed(value, self.robot.nominal_speed_mps)
        return speed_mps if speed_mps >= self._dead_band_mps else 0.0

    def _warm_up(self) -> None:
        """Call the policy on varied readings, so that its compiled code is loaded.

        Raises:
            InvalidInput: The policy cannot be used with such observations.
        """
        self._state, self._begins = None, True
        for k in range(_WARM_UP):
            share = k / (_WARM_UP - 1)
            people = [Person(1.0 + 4.0 * share, 0.3, -1.2, 0.1)] * (k % 3)
            ranges = tuple(0.5 + 3.5 * share for _ in self.layout.sensors)
            fields = dict.fromkeys(own_names(self.layout), 0.0)
            fields |= {"speed_mps": 0.3 * share, "remaining_m": 10.0}
            observation = self.observation(Readings(ranges, fields, people))
            with observing_layout(self.layout):
                action, self._state = self._policy.predict(
                    observation, state=self._state, episode_start=np.array([k == 0])
                )
            _action(action)


def _action(action: Actions) -> float:
    """Return the action of one observation; a whole number is a speed level."""
    value = np.asarray(action).reshape(-1)[0]
    return level_action(int(value)) if value.dtype.kind in "iu" else float(value)


def _positive(name: str, value: float) -> float:
    if not value > 0.0:
        raise InvalidInput(f"{name}: given {value:g}, allowed is more than 0")
    return value


def robot_for(policy: Policy, layout: Layout) -> Robot:
    """Return the robot that a policy is made for: the one of its training, or of the rules.

    Raises:
        InvalidInput: No policy is known for the layout.
    """
    parts = list(parts_of(policy, layout))
    for config in map(training_config, parts):
        if config is not None:
            return trained_robot(config)
    known = known_layout(layout.width)  # a robot's ring is taken for the named one of its size
    ring = layout.sensors if known is None else known.sensors
    needs = [each for each in map(needs_of, parts) if SPEED in each]
    return simulated_robot(
        ring, nominal_speed_mps=needs[0][SPEED] if needs else Robot().nominal_speed_mps
    )


def trained_robot(config: JsonObject) -> Robot:
    """Return the robot of an environment in which a policy was trained, from its config."""
    drive, sensors = config["drive"], config["sensors"]
    ring: Any = sensors["ring"]
    if not isinstance(ring, str):
        ring = tuple(RangeSensor(*each) for each in ring)
    return simulated_robot(
        ring,
        Ultrasonic(*sensors["ultrasonic"]),
        nominal_speed_mps=drive["nominal_speed_mps"],
        decision_period_s=config["clock"]["decision_s"],
        deceleration_mps2=drive["deceleration_mps2"],
    )
