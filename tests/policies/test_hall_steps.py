from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from hazbot_gym.core.proxemics import INTIMATE_M, PERSONAL_M, PERSONAL_NEAR_M, SOCIAL_NEAR_M
from hazbot_gym.policies.hall_steps import HallSteps
from hazbot_gym.policies.people_seen import RADII_M

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
