"""Every algorithm of Stable-Baselines3 and sb3-contrib learns for a moment."""

from __future__ import annotations

from typing import Any

import pytest

sb3 = pytest.importorskip("stable_baselines3")
contrib = pytest.importorskip("sb3_contrib")

from tests.clients.learn import algorithms, learn_and_act  # noqa: E402  (needs the library)

pytestmark = [pytest.mark.clients, pytest.mark.slow, pytest.mark.filterwarnings("default")]


@pytest.mark.parametrize("algorithm", [*algorithms(sb3), *algorithms(contrib)])
def test_every_algorithm_learns(algorithm: Any) -> None:
    learn_and_act(algorithm)


def test_there_are_as_many_as_the_page_says() -> None:
    assert (len(algorithms(sb3)), len(algorithms(contrib))) == (6, 7)
