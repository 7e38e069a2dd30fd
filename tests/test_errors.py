from __future__ import annotations

import sys
import types

import pytest

from hazbot_gym.errors import MissingExtra
from tests.refusals import says


def test_an_extra_that_is_not_there_is_told_from_one_that_is_broken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "half_there", types.ModuleType("half_there"))
    said = []
    for line in ("import not_there_at_all", "from half_there import other_half"):
        try:
            exec(line, {})
        except ImportError:
            said.append(str(MissingExtra("it", "train")))

    says(said[0], "pip install 'hazbot-gym[train]'")
    says(said[1], "cannot import name")
