"""Encounters of robot and human (paper section 5.1): a scenario, a policy, and events.

Events: the robot decelerates when its speed first falls below 98 % of nominal
after it was reached, stops below 5 %, and has recovered when it is above 98 % for good. In
simulations the speed is the commanded one, in experiments the robot's own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.batch_rollout import run_episodes
from hazbot_gym.evaluation.episode import PERSON_COLUMNS, Episode
from hazbot_gym.policies import make
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.fuzzy_expert import AVOIDANCE_M, SENSITIVE_M

SLOWER, STOPPED = 0.98, 0.05  # shares of the nominal speed
STEPS = 300  # decisions after which a meeting is over
X, Y = PERSON_COLUMNS.index("x"), PERSON_COLUMNS.index("y")


class Events(NamedTuple):
    """Event times of an encounter; NaN if an event did not occur."""

    decelerates_s: float
    stops_s: float
    recovers_s: float
    least_m: float  # distance between centres
    slowest_mps: float
    moving_inside_s: float  # time of the robot's motion with the human within 1.5 m
    hits: float  # 1 if it touched the human while it moved; a touch ends the meeting
    slow_outside_s: float  # time below 98 % with the human beyond 3.0 m


EVENT_NAMES = (  # of ``Events``, as heads of tables
    "decelerates [s]",
    "stops [s]",
    "recovers [s]",
    "least distance [m]",
    "slowest [m/s]",
    "moves within 1.5 m [s]",
    "touches the human moving [share]",
    "slow beyond 3.0 m [s]",
)


class Meeting(NamedTuple):
    """An encounter, sampled at every decision; all arrays (T,)."""

    time_s: Floats
    x: Floats  # of the robot [m]
    y: Floats
    human_x: Floats
    human_y: Floats
    distance_m: Floats  # between centres
    command_mps: Floats  # given at that time
    speed_mps: Floats
    position_error_m: Floats  # hypot(x_e, y_e)
    is_touching: bool  # at the end


def meet(
    scenario: str,
    policy: str | Policy = "fuzzy_expert",
    *,
    seeds: Sequence[int] = (0,),
    overrides: Mapping[str, object] | None = None,
    steps: int = STEPS,
) -> list[Meeting]:
    """Run a policy in a named scenario, once per noise seed."""
    config = make_config(overrides, scenario=scenario, max_episode_steps=steps)
    driver = make(policy) if isinstance(policy, str) else policy
    episodes = run_episodes(config, driver, list(seeds), limit=steps, threads=1)
    return [_meeting(episode) for episode, _ in episodes]


def _meeting(episode: Episode) -> Meeting:
    """Convert an episode record; commands are shifted by one instant."""
    human_x, human_y = episode.people[:-1, 0, X], episode.people[:-1, 0, Y]
    x, y = episode.pose[:-1, 0], episode.pose[:-1, 1]
    return Meeting(
        time_s=episode.time_s[:-1],
        x=x,
        y=y,
        human_x=human_x,
        human_y=human_y,
        distance_m=np.hypot(human_x - x, human_y - y),
        command_mps=episode.command_mps[1:],
        speed_mps=episode.speed_mps[:-1],
        position_error_m=np.hypot(episode.pose_error[:-1, 0], episode.pose_error[:-1, 1]),
        is_touching=episode.outcome == "contact_person",
    )


def events(meeting: Meeting, *, nominal_mps: float = 0.5, is_measured: bool = False) -> Events:
    """Return the events of an encounter.

    Args:
        meeting: The encounter.
        nominal_mps: The nominal speed.
        is_measured: Whether to use the robot's actual speed instead of the commanded one.
    """
    share = (meeting.speed_mps if is_measured else meeting.command_mps) / nominal_mps
    start = _first(share >= SLOWER)
    slow = _first((share < SLOWER) & (np.arange(len(share)) >= start))
    stop = _first((share < STOPPED) & (np.arange(len(share)) >= slow))
    below = np.flatnonzero(share < SLOWER)
    last = below[-1] + 1 if slow < len(share) and not meeting.is_touching else len(share)
    is_inside, is_outside = meeting.distance_m < SENSITIVE_M, meeting.distance_m > AVOIDANCE_M
    is_moving = np.abs(meeting.speed_mps) > STOPPED * nominal_mps
    step_s = float(meeting.time_s[1] - meeting.time_s[0])
    return Events(
        decelerates_s=_at(meeting, slow),
        stops_s=_at(meeting, stop),
        recovers_s=_at(meeting, last),
        least_m=float(meeting.distance_m.min()),
        slowest_mps=nominal_mps * float(share[start:].min()),
        moving_inside_s=step_s * float((is_inside & is_moving).sum()),
        hits=float(meeting.is_touching and is_moving[-1]),
        slow_outside_s=step_s * float(((share < SLOWER) & is_outside)[start:].sum()),
    )


def falls_below_s(meeting: Meeting, share: float, *, nominal_mps: float = 0.5) -> float:
    """Return the time at which the commanded speed first falls below a share of nominal, or NaN."""
    return _at(meeting, _first(meeting.command_mps < share * nominal_mps))


def slows_for_good_s(meeting: Meeting, *, nominal_mps: float = 0.5) -> float:
    """Return the last time at which the robot's actual speed leaves nominal, or NaN."""
    fast = np.flatnonzero(meeting.speed_mps >= SLOWER * nominal_mps)
    return _at(meeting, int(fast[-1]) + 1) if len(fast) else np.nan


def _first(is_so: npt.NDArray[np.bool_]) -> int:
    """Return the first True index, or the length."""
    return int(np.argmax(is_so)) if is_so.any() else len(is_so)


def _at(meeting: Meeting, index: int) -> float:
    return float(meeting.time_s[index]) if index < len(meeting.time_s) else np.nan


def spread(found: Sequence[Events]) -> dict[str, dict[str, float]]:
    """Return mean and deviation of each event over noise seeds, and its number of occurrences."""
    columns = {name: np.array([getattr(one, name) for one in found]) for name in Events._fields}
    return {
        name: {
            "mean": float(np.nanmean(values)) if np.isfinite(values).any() else np.nan,
            "sd": float(np.nanstd(values, ddof=1)) if np.isfinite(values).sum() > 1 else np.nan,
            "share": float(np.isfinite(values).mean()),
        }
        for name, values in columns.items()
    }


def start_of(scenario: str) -> dict[str, float]:
    """Return a scenario's initial distance [m], speeds [m/s], and sampling interval [s]."""
    config: Config = make_config(scenario=scenario)
    walker = config.people.walkers[0]
    return {
        "distance_m": float(np.hypot(walker.x_m, walker.y_m)),
        "human_mps": float(np.hypot(walker.vx_mps, walker.vy_mps)),
        "robot_mps": config.drive.nominal_speed_mps,
        "sampling_s": config.clock.decision_s,
    }
