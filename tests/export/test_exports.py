"""Exports answer as the policy in Python does, on 10,000 observations one after another."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from hazbot_gym.export.check import STRICT, c_actions, onnx_actions
from hazbot_gym.export.golden import TOLERANCE, actions_of, draw, golden_of, observations_for
from hazbot_gym.export.plan import Plan, plan_of
from hazbot_gym.export.write import ONNX, export
from hazbot_gym.policies.guard import Observations

COUNT = 10_000
ACTORS: list[dict[str, Any]] = [
    {},
    {"activation": "relu", "head": "squashed", "normalised": True, "tier": "tracks"},
    {"head": "levels"},
    {"lstm": 6, "normalised": True},
    {"residual": {"base": "constant:fraction=0.7", "scale": 0.5}},
    {"tier": "tracks", "lstm": 5, "residual": {"base": "ssm:mode=strict", "scale": 1.0}},
    {"tier": "tracks", "slots": 6, "residual": {"base": "ssm:mode=strict", "scale": 0.5}},
]
CROWDED: dict[str, Any] = {  # more entries than a byte can count
    "tier": "tracks", "slots": 20, "residual": {"base": "fuzzy_expert", "scale": 0.5},
}  # fmt: skip
LISTENING: dict[str, Any] = {"lstm": 6, "residual": {"base": "fuzzy_expert", "scale": 0.5}}
RULES = [
    "fuzzy_expert",
    "fuzzy_expert:rules=literal8,pattern=gaussian,t_norm=product",
    "fuzzy_expert:release=True,scale=1.3,horizon_s=0.5",
    "ssm:mode=strict,margin_m=0.2,nominal_mps=0.8",
    "constant:fraction=0.3",
    "ppo",
]
SONAR_RULES = ["fuzzy_expert:horizon_s=0.5,release=True", "ssm:mode=strict", "ppo"]
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")


def label(actor: dict[str, Any]) -> str:
    return ", ".join(f"{name}={value}" for name, value in actor.items()) or "plain"


def inputs_of(plan: Plan) -> tuple[Observations, Any]:
    """Return observations, some not valid, in rounds of 100."""
    observations = observations_for(plan, COUNT, seed=1)
    observations[50::1000, 0] = np.nan
    observations[51::1000, 1] = -0.5
    return observations, np.arange(COUNT) % 100 == 0


def compiled(folder: Path) -> subprocess.CompletedProcess[str]:
    """Build the test program as its comment says, and run it."""
    command = ["gcc", *STRICT, "hazbot_test.c", "hazbot_policy.c", "-o", "hazbot_test"]
    subprocess.run(command, cwd=folder, check=True)
    return subprocess.run([folder / "hazbot_test"], capture_output=True, text=True)


@needs_gcc
@pytest.mark.parametrize("actor", [*ACTORS, CROWDED, LISTENING], ids=label)
def test_networks_in_c_answer_as_python(
    actor: dict[str, Any], spec_of: Callable[..., str], tmp_path: Path
) -> None:
    plan = plan_of(spec_of(**actor))
    export(plan.spec, "c", tmp_path)
    observations, starts = inputs_of(plan)
    expected = actions_of(plan, observations, starts)

    found = c_actions(plan, tmp_path, observations, starts)
    assert np.ptp(expected) > 0.1
    assert np.abs(found - expected).max() <= TOLERANCE
    assert compiled(tmp_path).returncode == 0


@needs_gcc
@pytest.mark.parametrize(
    ("spec", "tier"),
    [(spec, "tracks") for spec in RULES] + [(spec, "sonar") for spec in SONAR_RULES],
)
def test_rules_in_c_answer_as_python(spec: str, tier: str, tmp_path: Path) -> None:
    plan = plan_of(spec, tier)
    export(spec, "c", tmp_path, tier=tier)
    observations, starts = inputs_of(plan)
    expected = actions_of(plan, observations, starts)

    assert np.abs(c_actions(plan, tmp_path, observations, starts) - expected).max() <= TOLERANCE
    done = compiled(tmp_path)
    assert (done.returncode, done.stdout[:17]) == (0, "64 golden vectors")


@pytest.mark.parametrize("actor", ACTORS, ids=label)
def test_networks_in_onnx_answer_as_python(
    actor: dict[str, Any], spec_of: Callable[..., str], tmp_path: Path
) -> None:
    pytest.importorskip("onnxruntime")
    plan = plan_of(spec_of(**actor))
    export(plan.spec, "onnx", tmp_path)
    observations, starts = inputs_of(plan)
    expected = actions_of(plan, observations, starts)

    model = (tmp_path / ONNX).read_bytes()
    assert np.abs(onnx_actions(plan, model, observations, starts) - expected).max() <= TOLERANCE


def test_the_shipped_policy_in_onnx_answers_as_python(tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime")
    plan = plan_of("ppo")
    export("ppo", "onnx", tmp_path)
    observations, starts = inputs_of(plan)
    expected = actions_of(plan, observations, starts)

    model = (tmp_path / ONNX).read_bytes()
    assert np.abs(onnx_actions(plan, model, observations, starts) - expected).max() <= TOLERANCE


@needs_gcc
@pytest.mark.parametrize("level", ["-O0", "-O3", "-Os"])
def test_c_compiles_without_a_warning_at_every_level_and_calls_no_library(
    level: str, spec_of: Callable[..., str], tmp_path: Path
) -> None:
    export(spec_of(**LISTENING), "c", tmp_path)
    command = ["gcc", *STRICT, level, "-c", "hazbot_policy.c", "-o", "policy.o"]
    subprocess.run(command, cwd=tmp_path, check=True)

    missing = subprocess.run(
        ["nm", "-u", "policy.o"], cwd=tmp_path, check=True, capture_output=True, text=True
    ).stdout.split()
    assert set(missing) - {"U"} <= {"memcpy", "memset", "__stack_chk_fail", "_GLOBAL_OFFSET_TABLE_"}


@needs_gcc
def test_the_test_program_fails_for_other_answers(tmp_path: Path) -> None:
    export("constant:fraction=0.3", "c", tmp_path)
    source = tmp_path / "hazbot_policy.c"
    source.write_text(source.read_text().replace("return 0.300", "return 0.310"))
    assert compiled(tmp_path).returncode == 1


@needs_gcc
def test_c_encodes_fields_as_python(tmp_path: Path) -> None:
    import ctypes

    export("constant", "c", tmp_path)
    library = tmp_path / "policy.so"
    command = ["gcc", *STRICT, "-shared", "-fPIC", "-o", library, tmp_path / "hazbot_policy.c"]
    subprocess.run(command, check=True)
    layout = plan_of("constant").layout
    fields = np.random.default_rng(0).uniform(-6.0, 6.0, layout.width).astype(np.float32)
    out = np.zeros(layout.width, np.float32)
    encode = ctypes.CDLL(str(library)).hazbot_encode
    encode(*(array.ctypes.data_as(ctypes.c_void_p) for array in (fields, out)))
    assert out == pytest.approx(layout.encode(dict(zip(layout.names, fields, strict=True))))


def test_golden_vectors_are_those_of_the_policy(
    spec_of: Callable[..., str], tmp_path: Path
) -> None:
    plan = plan_of(spec_of(lstm=4))
    export(plan.spec, "c", tmp_path)
    golden = json.loads((tmp_path / "golden.json").read_text())

    assert [field["name"] for field in golden["fields"]] == list(plan.layout.names)
    assert (golden["nominal_speed_mps"], golden["decision_period_s"]) == (0.5, 0.1)
    assert golden["actions"] == pytest.approx(golden_of(plan).actions.tolist())
    assert golden["actions"][8] == -1.0  # an observation out of bounds
    assert golden["starts"].count(True) == 4


def test_drawn_observations_are_people_in_order_with_one_pattern_at_most() -> None:
    plan = plan_of("fuzzy_expert")
    seen = plan.layout.decode(draw(plan.layout, 500, seed=0))

    assert (seen["person0_distance_m"] <= seen["person1_distance_m"]).all()
    assert set(seen["person2_present"]) == {0.0, 1.0}
    patterns = ("crossing", "encountering", "leading", "confronting")
    assert set(sum(seen[f"person0_{name}"] for name in patterns)) == {0.0, 1.0}


class Heard(NamedTuple):
    """The fuzzy expert on echoes, with observations and its answers."""

    plan: Plan
    observations: Observations
    starts: Any
    expected: Any


@pytest.fixture(scope="module")
def heard() -> Heard:
    plan = plan_of("fuzzy_expert", "sonar")
    observations, starts = inputs_of(plan)
    return Heard(plan, observations, starts, actions_of(plan, observations, starts))


@needs_gcc
@pytest.mark.parametrize(
    "constant", ["0.35", "0.25", "1.5", "2.0", "2.5", "0.3", "0.2", "3.9", "0.6", "2.7"]
)
def test_the_observations_reach_every_constant_of_the_echo_filter(
    constant: str, heard: Heard, tmp_path: Path
) -> None:
    export(heard.plan.spec, "c", tmp_path, tier="sonar")
    source = tmp_path / "hazbot_policy.c"
    parts = r"(?s)(/\* --- people from echoes.*?/\* --- the fuzzy)"
    head, echoes, rest = re.split(parts, source.read_text())
    number = rf"(?<![\d.]){re.escape(constant)}\d*(?![\d.]*e)"
    changed = re.sub(number, f"({constant} + 0.1)", echoes)
    assert changed != echoes
    source.write_text(head + changed + rest)

    found = c_actions(heard.plan, tmp_path, heard.observations, heard.starts)
    assert np.abs(found - heard.expected).max() > TOLERANCE
