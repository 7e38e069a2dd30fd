from __future__ import annotations

import pytest

from hazbot_gym.study.config import DEFAULT_POLICIES
from hazbot_gym.study.report.style import DASHES, MARKS, styles

MANY = (*DEFAULT_POLICIES, "ssm", "ssm:directional", "mine:Policy")


def contrast_to_white(color: str) -> float:
    """WCAG 2's contrast ratio."""
    parts = [value / 255 for value in bytes.fromhex(color[1:])]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 1.05 / (0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2] + 0.05)


def test_no_two_policies_look_alike() -> None:
    looks = styles(MANY)
    assert list(looks) == list(MANY)
    assert len(set(looks.values())) == len(MANY)


def test_every_colour_can_be_seen_on_white() -> None:
    assert min(contrast_to_white(look.color) for look in styles(MANY).values()) >= 3.0


def test_a_family_shares_its_mark_and_constants_are_the_grey_front() -> None:
    looks = styles(MANY)
    assert looks["ssm"].mark == looks["ssm:directional"].mark
    assert looks["ssm"].mark != looks["ppo"].mark
    swept = [look for policy, look in looks.items() if policy.startswith("constant:")]
    assert all(look.is_swept and look.color[1:3] == look.color[3:5] for look in swept)
    assert not any(look.is_swept for policy, look in looks.items() if "constant" not in policy)


@pytest.mark.parametrize("policies", [("constant:1.0",), tuple(f"p{i}" for i in range(20))])
def test_any_number_of_policies_has_styles(policies: tuple[str, ...]) -> None:
    for look in styles(policies).values():
        assert look.dash in DASHES
        assert look.mark in MARKS
