from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hazbot_gym.policies.idm import SOON_S, Idm
from hazbot_gym.policies.people_seen import RADII_M

Maker = Callable[..., Any]
POLICY = Idm(headway_s=1.5, lane_m=0.6, gap_m=0.4)


@pytest.mark.parametrize(
    ("command", "expected"), [(0.0, 0.1), (0.25, 0.5 + 0.1 * (1.0 - 0.5**4)), (0.5, 1.0)]
)
def test_alone_it_gains_speed_ever_more_slowly(
    observe: Maker, share: Maker, command: float, expected: float
) -> None:
    assert share(POLICY, observe(v=command, command=command)) == pytest.approx(expected, abs=1e-6)


def test_behind_a_leader_of_its_own_speed_it_keeps_gap_and_headway(
    observe: Maker, share: Maker
) -> None:
    v = 0.3
    gap_m = (0.4 + 1.5 * v) / math.sqrt(1.0 - (v / 0.5) ** 4)
    for off_m, change in ((0.0, 0), (0.05, 1), (-0.05, -1)):
        seen = observe((RADII_M + gap_m + off_m, 0.0, v, 0.0), v=v, command=v)
        assert np.sign(round(share(POLICY, seen) - v / 0.5, 5)) == change


def test_it_brakes_the_more_the_faster_the_gap_closes(observe: Maker, share: Maker) -> None:
    shares = [share(POLICY, observe((2.5, 0.0, u, 0.0), v=0.4, command=0.4)) for u in (0.4, 0, -1)]
    assert shares == sorted(shares, reverse=True)
    assert len(set(shares)) == 3


@pytest.mark.parametrize(
    ("person", "counts"),
    [
        ((1.5, 0.5, 0.0, 0.0), True),
        ((1.5, 0.7, 0.0, 0.0), False),  # stands beside the lane
        ((1.5, 1.2, 0.0, -0.8), True),  # steps into it
        ((1.5, 1.2, 0.0, 0.8), False),  # walks away from it
        ((1.5, 0.6 + 0.2 * (SOON_S + 1.0), 0.0, -0.2), False),  # not before long
        ((0.0, 1.2, -0.5, -0.8), False),  # steps in behind
        ((-1.5, 0.0, 0.4, 0.0), False),
    ],
)
def test_who_is_in_the_lane_or_about_to_be_counts(
    observe: Maker, share: Maker, person: tuple[float, float, float, float], counts: bool
) -> None:
    alone = share(POLICY, observe(v=0.4, command=0.4))
    assert (share(POLICY, observe(person, v=0.4, command=0.4)) < alone) == counts
