"""Plot style of each policy: colour, dash and marker, the same in every figure and table.

A policy shown by default has a hue of its own; the other members of its family share it, and
differ in dash and mark. The constant speeds are the swept reference and stay grey, from light for
slow to dark for fast (on dark paper the other way round).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hazbot_gym.study.default_policies import CONSTANT, family_of

# Each on white and on dark paper, with a contrast of at least 3. The first five, which are those of
# policies shown by default, differ from each other and from the greys also under colour blindness.
HUES = (
    ("#0a4da8", "#8cb8ff"),
    ("#e07000", "#f28f29"),
    ("#12753f", "#218a4c"),
    ("#b45ae0", "#a64be0"),
    ("#571e08", "#f2e7a0"),
    ("#d87495", "#c79ea9"),
    ("#0a7d8c", "#629092"),
    ("#7d7400", "#b5a642"),
)
GREYS = ("#949494", "#161616"), ("#6a6a6a", "#fafafa")  # slowest and fastest, on either paper
DASHES = {"solid": "", "dash": "7 3", "dot": "2 3", "dashdot": "7 3 2 3"}  # plotly's, and SVG's
MARKS = {  # plotly's name, and the same as an SVG path about the origin; the first is of constants
    "circle": "M-4,0a4,4 0 1,0 8,0a4,4 0 1,0 -8,0",
    "square": "M-3.5,-3.5h7v7h-7z",
    "diamond": "M0,-5l5,5l-5,5l-5,-5z",
    "triangle-up": "M0,-4.5l4.5,8h-9z",
    "triangle-down": "M0,4.5l4.5,-8h-9z",
    "cross": "M-4.5,-1.5h3v-3h3v3h3v3h-3v3h-3v-3h-3z",
    "star": "M0,-5l1.5,3.1l3.4,.4l-2.5,2.4l.6,3.4l-3,-1.6l-3,1.6l.6,-3.4l-2.5,-2.4l3.4,-.4z",
    "hexagon": "M0,-4.5l3.9,2.25v4.5l-3.9,2.25l-3.9,-2.25v-4.5z",
    "x": "M0,-2.1l2.4,-2.4l2.1,2.1l-2.4,2.4l2.4,2.4l-2.1,2.1l-2.4,-2.4l-2.4,2.4l-2.1,-2.1l2.4,-2.4"
    "l-2.4,-2.4l2.1,-2.1z",
}


class Style(NamedTuple):
    """Style of one policy; dash and mark are keys of ``DASHES`` and ``MARKS``."""

    color: str  # on white paper
    dark: str  # on dark paper
    dash: str
    mark: str
    is_swept: bool


def styles(policies: Sequence[str], first: Sequence[str] = ()) -> dict[str, Style]:
    """Return the style of every policy of a study, by their order and by those shown by default.

    Args:
        policies: all policies.
        first: those shown by default.
    """
    swept = [policy for policy in policies if family_of(policy) == CONSTANT]
    chosen = {policy: _grey(i, len(swept)) for i, policy in enumerate(swept)}
    hues: dict[str, int] = {}  # of each family
    members: dict[int, int] = {}  # number of policies of each hue
    for policy in [*first, *policies]:
        if policy in chosen:
            continue
        family, free = family_of(policy), len(members)
        hue = free if policy in first else hues.get(family, free)
        hues.setdefault(family, hue)
        members[hue] = members.get(hue, 0) + 1
        chosen[policy] = _colored(hue, members[hue] - 1)
    return {policy: chosen[policy] for policy in policies}


def _grey(i: int, count: int) -> Style:
    color, dark = (_mix(*greys, i / max(count - 1, 1)) for greys in GREYS)
    return Style(color, dark, _nth(DASHES, i), "circle", is_swept=True)


def _colored(hue: int, variant: int) -> Style:
    again = hue // len(HUES)  # more hues than there are
    marks = list(MARKS)[1:]
    return Style(
        *HUES[hue % len(HUES)],
        _nth(DASHES, hue + variant + again),
        marks[(hue + variant + again) % len(marks)],
        is_swept=False,
    )


def _nth(names: dict[str, str], i: int) -> str:
    return list(names)[i % len(names)]


def _mix(start: str, end: str, share: float) -> str:
    """Interpolate between two colours ``#rrggbb``."""
    a, b = bytes.fromhex(start[1:]), bytes.fromhex(end[1:])
    return "#" + bytes(round(x + share * (y - x)) for x, y in zip(a, b, strict=True)).hex()
