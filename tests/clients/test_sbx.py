"""Every algorithm of sbx learns for a moment."""

from __future__ import annotations

from typing import Any

import pytest

sbx = pytest.importorskip("sbx")

from tests.clients.learn import algorithms, learn_and_act  # noqa: E402  (needs the library)

pytestmark = [pytest.mark.clients, pytest.mark.slow, pytest.mark.filterwarnings("default")]


@pytest.mark.parametrize("algorithm", algorithms(sbx))
def test_every_algorithm_learns(algorithm: Any) -> None:
    learn_and_act(algorithm)
