"""Names that are reachable from the top of the package."""

from __future__ import annotations

import subprocess
import sys

import pytest

import hazbot_gym


def test_every_name_of_the_face_is_there() -> None:
    for name in hazbot_gym.__all__:
        assert getattr(hazbot_gym, name).__name__ in (name, "make")
        assert name in dir(hazbot_gym)


def test_other_names_are_missing() -> None:
    with pytest.raises(AttributeError, match="no attribute 'study_of_everything'"):
        hazbot_gym.study_of_everything  # type: ignore[attr-defined]  # noqa: B018


def test_evaluation_needs_no_torch() -> None:
    code = "import sys; from hazbot_gym import evaluate, means; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
