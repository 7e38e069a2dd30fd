from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hazbot_gym.export.plan import plan_of
from hazbot_gym.export.write import export
from tests.refusals import refused


@pytest.mark.parametrize(
    ("spec", "tier", "said"),
    [
        ("telepathy", None, "telepathy"),
        ("mpc", None, "mpc ... cannot be exported ... fuzzy_expert"),
        ("ssm:mode=directional", None, "ssm:mode=directional ... ssm:mode=strict"),
        ("fuzzy_reading:reading=centroid", None, "fuzzy_reading"),
        ("ppo", "radar", "radar ... sonar"),
        ("learned:path=model.zip", None, "model.zip ... statistics ... .npz"),
    ],
)
def test_what_cannot_be_exported_is_refused(spec: str, tier: str | None, said: str) -> None:
    with refused(said):
        plan_of(spec, tier)


def test_a_trained_policy_has_its_own_tier(spec_of: Callable[..., str]) -> None:
    spec = spec_of(tier="sonar")
    assert plan_of(spec).layout.width == 12
    with refused("tier ... 51 ... sonar ... 12"):
        plan_of(spec, "tracks")


def test_rules_have_no_onnx(spec_of: Callable[..., str], tmp_path: Path) -> None:
    pytest.importorskip("onnx")
    with refused("format ... onnx ... fuzzy_expert ... c"):
        export("fuzzy_expert", "onnx", tmp_path)
    spec = spec_of(tier="tracks", residual={"base": "fuzzy_expert", "scale": 1.0})
    with refused("format ... onnx ... FuzzyExpert ... c"):
        export(spec, "onnx", tmp_path)
    with refused("format ... onnx ... echoes ... 'ppo' ... c"):
        export("ppo", "onnx", tmp_path, tier="sonar")


def test_files_are_replaced_only_when_asked(tmp_path: Path) -> None:
    first = export("constant", "c", tmp_path)
    with refused("hazbot_policy.h ... exists ... --force"):
        export("constant:0.5", "c", tmp_path)
    again = export("constant:0.5", "c", tmp_path, overwrite=True)

    assert [path.name for path in first] == [path.name for path in again]
    assert "0.5f;" in (tmp_path / "hazbot_policy.c").read_text()


def test_another_format_is_refused(tmp_path: Path) -> None:
    with refused("format ... 'rust' ... onnx, c"):
        export("constant", "rust", tmp_path)
