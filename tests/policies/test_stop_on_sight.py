from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.policies.stop_on_sight import StopOnSight
from hazbot_gym.task.observation import LAYOUTS

LAYOUT = LAYOUTS["sonar"]


def observed(*ahead_m: float, right_m: float = 4.0) -> npt.NDArray[np.float32]:
    """Return observations (N, n) with a reading of the sensor in front on the left."""
    rows = np.zeros((len(ahead_m), LAYOUT.width), np.float32)
    scale = LAYOUT.fields[0].scale
    rows[:, LAYOUT.names.index("range_front_left_m")] = np.array(ahead_m) / scale
    rows[:, LAYOUT.names.index("range_front_right_m")] = right_m / scale
    return rows


def test_it_stops_at_one_distance_and_goes_on_at_another() -> None:
    policy, state, actions = StopOnSight(0.8, 1.2), None, []
    for ahead_m in (2.0, 1.0, 0.7, 1.0, 1.1, 1.3, 1.0):
        action, state = policy.predict(observed(ahead_m)[0], state)
        assert action.shape == (1,)
        actions.append(float(action[0]))
    assert actions == [1.0, 1.0, -1.0, -1.0, -1.0, 1.0, 1.0]


def test_worlds_have_their_own_states_and_an_episode_begins_anew() -> None:
    policy = StopOnSight(0.8, 1.2)
    _, state = policy.predict(observed(0.5, 2.0, 0.5))
    action, state = policy.predict(observed(1.0, 1.0, 1.0), state, np.array([False, False, True]))
    assert action[:, 0].tolist() == [-1.0, 1.0, 1.0]
    assert state.tolist() == [True, False, False]


def test_either_sensor_in_front_stops_it() -> None:
    assert StopOnSight().predict(observed(4.0, right_m=0.3))[0].item() == -1.0


def test_resumes_a_fixed_distance_farther_away_if_not_told() -> None:
    policy = StopOnSight(stop_m=1.0)
    _, state = policy.predict(observed(0.9))
    assert policy.predict(observed(1.39), state)[0].item() == -1.0
    assert policy.predict(observed(1.41), state)[0].item() == 1.0
