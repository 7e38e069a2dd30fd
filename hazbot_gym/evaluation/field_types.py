"""Types of config fields that studies and training runs share, with their bounds."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, MinLen

from hazbot_gym.config.section import Loose

Engine = Literal["batched", "pymunk"]  # the reference is pymunk; both give the same numbers


# Bounds beyond any real study: they catch a misplaced digit that would take a year or all memory.
MOST_EPISODES, MOST_SEED = 1_000_000, 2**64 - 1
Episodes = Annotated[int, Ge(1), Le(MOST_EPISODES)]
Steps = Annotated[int, Ge(1), Le(100_000_000_000)]
Seed = Annotated[int, Ge(0), Le(MOST_SEED)]
Positive = Annotated[float, Gt(0)]
Names = Annotated[tuple[str, ...], Loose]
SomeNames = Annotated[tuple[str, ...], Loose, MinLen(1)]
