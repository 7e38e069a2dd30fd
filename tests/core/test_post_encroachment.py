"""Post-encroachment time, against all pairs of instants written out."""

import numpy as np
import pytest

from hazbot_gym.core.post_encroachment import ACROSS, post_encroachment_time
from hazbot_gym.core.state import Floats

REACH_M = 0.55


def written_out(time_s: Floats, pose: Floats, person_time_s: Floats, person: Floats) -> float:
    gap = np.hypot(*(pose[:, None, axis] - person[:, axis] for axis in (0, 1)))
    turned = np.subtract.outer(pose[:, 2], np.arctan2(person[:, 3], person[:, 2]))
    apart = np.abs(np.subtract.outer(time_s, person_time_s))
    return float(apart[(gap < REACH_M) & (np.abs(np.sin(turned)) >= ACROSS)].min(initial=np.inf))


@pytest.mark.parametrize("seed", range(8))
def test_it_is_the_least_over_all_pairs_of_instants(seed: int) -> None:
    rng = np.random.default_rng(seed)
    time_s, person_time_s = 0.1 * np.arange(60), 2.0 + 0.1 * np.arange(40)
    pose = np.cumsum(rng.normal(0.05, 0.05, (60, 3)), axis=0)
    velocity = rng.normal(0.0, 0.7, 2) * np.ones((40, 2))
    place = pose[rng.integers(60), :2] + np.subtract.outer(person_time_s, 4.0)[:, None] * velocity
    person = np.hstack([place, velocity])
    found = post_encroachment_time(time_s, pose, person_time_s, person, REACH_M)
    assert found == pytest.approx(written_out(time_s, pose, person_time_s, person))


def test_nobody_is_never_met() -> None:
    nobody = np.empty((0, 4))
    assert (
        post_encroachment_time(np.zeros(2), np.zeros((2, 3)), nobody[:, 0], nobody, 1.0) == np.inf
    )
