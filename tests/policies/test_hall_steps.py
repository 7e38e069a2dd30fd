from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.proxemics import INTIMATE_M, PERSONAL_M, PERSONAL_NEAR_M, SOCIAL_NEAR_M
from hazbot_gym.policies import make
from hazbot_gym.policies.hall_steps import HallSteps
from hazbot_gym.policies.people_seen import RADII_M
from tests.refusals import refused

Maker = Callable[..., Any]
WITHIN = {INTIMATE_M: 0.0, PERSONAL_NEAR_M: 0.25, PERSONAL_M: 0.5, SOCIAL_NEAR_M: 0.75}


@pytest.mark.parametrize("scale", [1.0, 1.5])
@pytest.mark.parametrize(("bound_m", "expected"), WITHIN.items())
def test_each_zone_has_its_speed(
    observe: Maker, share: Maker, bound_m: float, expected: float, scale: float
) -> None:
    within = observe((scale * bound_m + RADII_M - 0.01, 0.0, 0.0, 0.0), v=0.5)
    beyond = observe((scale * bound_m + RADII_M + 0.01, 0.0, 0.0, 0.0), v=0.5)
    assert share(HallSteps(scale), within) == expected
    assert share(HallSteps(scale), beyond) == expected + 0.25


def test_alone_it_drives_at_nominal_speed_and_the_nearest_person_counts(
    observe: Maker, share: Maker
) -> None:
    near, far = (0.0, -1.0, 0.0, 0.0), (3.5, 0.0, 0.0, 0.0)
    assert share(HallSteps(1.0), observe(v=0.5)) == 1.0
    assert share(HallSteps(1.0), observe(near, far, v=0.5)) == 0.25
    rows = np.stack([observe(far, v=0.5), observe(near, far, v=0.5)])
    assert HallSteps(1.0).predict(rows)[0].tolist() == [[1.0], [-0.5]]


def test_zones_turned_inside_out_are_refused() -> None:
    with refused("scale"):
        make("hall_steps:scale=-1")
