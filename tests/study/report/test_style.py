from __future__ import annotations

import itertools

import pytest

from hazbot_gym.study.config import DEFAULT_POLICIES
from hazbot_gym.study.report.style import DASHES, HUES, MARKS, Style, styles

Color = pytest.importorskip("coloraide", reason="needs the extra dev").Color

MANY = (*DEFAULT_POLICIES, "ssm", "ssm:directional", "mine:Policy")
CONSTANTS = ("constant:0.25", "constant:0.5", "constant:0.75", "constant:1.0")
PAPERS = ("#ffffff", "#15191d")
LEAST_DELTA_E = 10.0  # CIEDE2000
# Default policies of the quick study, and the most hues that a study can have by default.
DEFAULTS = (
    ("fuzzy_expert", "ppo", "ssm:mode=strict", *CONSTANTS[:3]),
    ("fuzzy_expert, tuned", "one ppo", "another ppo", "fuzzy_expert", "mpc", CONSTANTS[0]),
)


def seen(color: str, vision: str) -> Color:
    """Return a color as seen with full or without red or green cones (Machado et al. 2009)."""
    found = Color(color)
    return found if vision == "normal" else found.filter(vision, method="machado")


@pytest.mark.parametrize("vision", ["normal", "protan", "deutan"])
@pytest.mark.parametrize("paper", [0, 1])
@pytest.mark.parametrize("first", DEFAULTS)
def test_colors_of_default_policies_differ_for_every_vision(
    first: tuple[str, ...], paper: int, vision: str
) -> None:
    looks = styles(tuple(dict.fromkeys((*first, *CONSTANTS))), first)
    shown = [seen(looks[policy][paper], vision) for policy in (*first, *CONSTANTS)]
    pairs = [pair for pair in itertools.combinations(shown, 2) if pair[0] != pair[1]]
    assert min(a.delta_e(b, method="2000") for a, b in pairs) >= LEAST_DELTA_E


def test_default_policies_differ_in_dash_or_mark_as_well() -> None:
    for first in DEFAULTS:
        looks = [styles(first, first)[policy] for policy in first]
        assert len({(look.dash, look.mark) for look in looks}) == len(first)


def test_no_two_policies_look_alike() -> None:
    looks = styles(MANY)
    assert list(looks) == list(MANY)
    assert len(set(looks.values())) == len(MANY)


@pytest.mark.parametrize("paper", [0, 1])
def test_every_color_can_be_seen_on_its_paper(paper: int) -> None:
    colors = [*(hue[paper] for hue in HUES), *(look[paper] for look in styles(MANY).values())]
    assert min(Color(color).contrast(PAPERS[paper]) for color in colors) >= 3.0  # WCAG 2


def test_a_family_shares_its_hue_and_constants_are_the_grey_front() -> None:
    looks = styles((*MANY, "ssm, tuned", "constant, tuned"))
    assert looks["ssm"].color == looks["ssm:directional"].color == looks["ssm, tuned"].color
    assert looks["ssm"].color != looks["ppo"].color
    swept = [look for policy, look in looks.items() if policy.startswith("constant")]
    assert all(look.is_swept and look.color[1:3] == look.color[3:5] for look in swept)
    assert not any(look.is_swept for policy, look in looks.items() if "constant" not in policy)


def test_a_default_policy_has_a_hue_of_its_own_in_the_order_of_the_defaults() -> None:
    first = ("ssm:directional", "ssm")
    looks = styles(MANY, first)
    assert [looks[policy][:2] for policy in first] == list(HUES[:2])


@pytest.mark.parametrize("policies", [("constant:1.0",), tuple(f"p{i}" for i in range(20))])
def test_any_number_of_policies_has_styles(policies: tuple[str, ...]) -> None:
    for look in styles(policies).values():
        assert isinstance(look, Style)
        assert look.dash in DASHES
        assert look.mark in MARKS
