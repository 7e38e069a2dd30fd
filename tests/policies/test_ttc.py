from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hazbot_gym.policies.ttc import SHARES, Ttc

Maker = Callable[..., Any]


@pytest.mark.parametrize(
    ("gap_m", "expected"), [(1.1, 1.0), (0.9, 0.75), (0.6, 0.5), (0.4, 0.25), (0.2, 0.0)]
)
def test_somebody_who_stands_ahead_is_neared_at_a_speed_that_leaves_the_horizon(
    observe: Maker, share: Maker, gap_m: float, expected: float
) -> None:
    standing = observe((0.5 + gap_m, 0.0, 0.0, 0.0), v=0.25)
    assert share(Ttc(horizon_s=2.0, margin_m=0.0), standing) == expected


def test_margin_keeps_so_much_farther_away(observe: Maker, share: Maker) -> None:
    near, far = (observe((x, 0.0, 0.0, 0.0), v=0.25) for x in (1.1, 1.4))
    assert share(Ttc(2.0, margin_m=0.3), far) == share(Ttc(2.0, margin_m=0.0), near) == 0.5


def test_somebody_who_passes_beside_does_not_slow_it_down(observe: Maker, share: Maker) -> None:
    beside = observe((2.0, 0.7, -1.3, 0.0), v=0.5)
    assert share(Ttc(margin_m=0.0), beside) == 1.0
    assert share(Ttc(margin_m=0.3), beside) < 1.0


def test_it_stops_where_no_speed_helps(observe: Maker, share: Maker) -> None:
    assert share(Ttc(), observe((1.5, 0.0, -1.3, 0.0), v=0.5)) == 0.0


def test_it_lets_somebody_cross_and_tells_to_which_side_the_person_walks(
    observe: Maker, share: Maker
) -> None:
    to_the_way = observe((1.0, 1.5, 0.0, -1.0), v=0.5)
    off_the_way = observe((1.0, 1.5, 0.0, 1.0), v=0.5)
    assert share(Ttc(margin_m=0.0), to_the_way) < 1.0
    assert share(Ttc(margin_m=0.0), off_the_way) == 1.0


def test_only_who_walks_into_the_way_counts(observe: Maker, share: Maker) -> None:
    # The second velocity is the first one, mirrored at the line of sight.
    into_the_way, out_of_it = (1.0, 1.2, 0.0, -0.6), (1.0, 1.2, -0.59, -0.108)
    policy = Ttc(horizon_s=3.0, margin_m=0.0)
    for v in (0.0, 0.5):
        assert share(policy, observe(into_the_way, v=v)) < 1.0
        assert share(policy, observe(out_of_it, v=v)) == 1.0


def test_longer_horizon_is_never_faster_towards_somebody_who_stands_or_comes(
    observe: Maker, share: Maker
) -> None:
    for u in (0.0, -0.8):
        for x in np.linspace(0.6, 4.0, 12):
            person = observe((float(x), 0.0, u, 0.0), v=0.3)
            shares = [share(Ttc(h), person) for h in (0.5, 1.0, 2.0, 4.0)]
            assert shares == sorted(shares, reverse=True)
            assert set(shares) <= set(SHARES)
