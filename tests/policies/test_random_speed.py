"""The policy ``random``."""

from __future__ import annotations

import numpy as np

from hazbot_gym import policies
from hazbot_gym.task.observation import LAYOUTS

WIDTH = LAYOUTS["sonar"].width
SEEN = np.random.default_rng(0).uniform(0.1, 0.9, (2000, WIDTH)).astype(np.float32)


def test_speeds_are_uniform() -> None:
    actions, _ = policies.make("random").predict(SEEN)
    counts, _ = np.histogram(actions, bins=10, range=(-1.0, 1.0))
    assert counts.sum() == 2000
    assert np.abs(counts - 200).max() < 5 * np.sqrt(200)


def test_a_draw_is_the_same_alone_and_in_a_batch_and_another_for_another_seed() -> None:
    policy = policies.make("random:seed=7")
    actions, _ = policy.predict(SEEN)
    alone, _ = policy.predict(SEEN[5])
    assert alone == actions[5]
    others, _ = policies.make("random:seed=8").predict(SEEN)
    assert np.abs(np.corrcoef(actions[:, 0], others[:, 0])[0, 1]) < 0.1
