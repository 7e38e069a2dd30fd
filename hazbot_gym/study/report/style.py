"""Plot style of each policy: colour, dash and marker, the same in every figure and table.

Variants of a family (``fuzzy_expert:...``) share a hue and a mark. The family of constant speeds is
the swept reference and stays grey, from light for slow to dark for fast.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

SWEPT = "constant"  # the family joined to a front

# Hues with a contrast of 4.5 to white, distinguishable for most colour-blind readers.
HUES = ("#0067a5", "#b83a00", "#00785a", "#8a3c8f", "#856200", "#007a87", "#b8336a")
GREYS = ("#8c8c8c", "#333333")  # slowest and fastest of the swept family
DASHES = {"solid": "", "dash": "7 3", "dot": "2 3", "dashdot": "7 3 2 3"}  # plotly's, and SVG's
MARKS = {  # plotly's name, and the same as an SVG path about the origin
    "circle": "M-4,0a4,4 0 1,0 8,0a4,4 0 1,0 -8,0",
    "square": "M-3.5,-3.5h7v7h-7z",
    "diamond": "M0,-5l5,5l-5,5l-5,-5z",
    "triangle-up": "M0,-4.5l4.5,8h-9z",
    "triangle-down": "M0,4.5l4.5,-8h-9z",
}


class Style(NamedTuple):
    """Style of one policy; dash and mark are keys of ``DASHES`` and ``MARKS``."""

    color: str
    dash: str
    mark: str
    is_swept: bool


def family_of(policy: str) -> str:
    """Return a policy's family, the name before its options."""
    return policy.partition(":")[0]


def styles(policies: Sequence[str]) -> dict[str, Style]:
    """Return the style of every policy of a study; styles depend on their order alone."""
    families = _grouped(policies)
    hues = [family for family in families if family != SWEPT]
    chosen = {}
    for family, members in families.items():
        for i, policy in enumerate(members):
            if family == SWEPT:
                color = _mix(*GREYS, i / max(len(members) - 1, 1))
            else:
                hue = HUES[hues.index(family) % len(HUES)]
                color = _mix(hue, "#ffffff", 0.28 * i / max(len(members) - 1, 1))
            place = 0 if family == SWEPT else 1 + hues.index(family) % (len(MARKS) - 1)
            dash = list(DASHES)[i % len(DASHES)]
            chosen[policy] = Style(color, dash, list(MARKS)[place], family == SWEPT)
    return {policy: chosen[policy] for policy in policies}


def _grouped(policies: Iterable[str]) -> dict[str, list[str]]:
    families: dict[str, list[str]] = {}
    for policy in policies:
        families.setdefault(family_of(policy), []).append(policy)
    return families


def _mix(start: str, end: str, share: float) -> str:
    """Interpolate between two colours ``#rrggbb``."""
    a, b = bytes.fromhex(start[1:]), bytes.fromhex(end[1:])
    return "#" + bytes(round(x + share * (y - x)) for x, y in zip(a, b, strict=True)).hex()
