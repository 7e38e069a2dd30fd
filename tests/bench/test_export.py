from __future__ import annotations

from pathlib import Path

import pytest

from hazbot_gym.bench import export
from hazbot_gym.export.golden import TOLERANCE
from hazbot_gym.utils.files import read_json
from tests.refusals import refused

RECORD = read_json(Path(__file__).parents[2] / "benchmarks" / "export.json")


@pytest.mark.skipif(bool(export.tools()), reason="needs gcc-arm-none-eabi and qemu-system-arm")
@pytest.mark.parametrize("tier", ["tracks", "sonar"])
def test_the_fuzzy_expert_answers_on_a_cortex_m3_as_in_python(tier: str, tmp_path: Path) -> None:
    found = export.measure("fuzzy_expert", tier, tmp_path)

    assert found["golden_difference"] <= TOLERANCE
    assert found["difference"]["c"] <= TOLERANCE
    assert found["instructions_a_tick"] == pytest.approx(40.0, rel=0.01)  # 25 MHz, 1 ns each
    assert 1_000 < found["instructions"] < 200_000
    assert 2_000 < found["flash_bytes"] < 16_000
    assert found["ram_bytes"] == 0
    assert (found["memory_bytes"] > 0) is (tier == "sonar")


def test_the_record_is_of_equal_answers_that_fit_the_paper_s_processor() -> None:
    for case in RECORD["cases"].values():
        assert max(case["difference"].values()) <= TOLERANCE
        assert case["golden_difference"] <= TOLERANCE
        assert case["stack_bytes"] + case["memory_bytes"] < 20_000
        assert case["flash_bytes"] < 128_000


def test_every_case_has_a_row_in_both_tables() -> None:
    for titles, rows in (
        (export.EQUAL, export.equality_rows(RECORD)),
        (export.SIZES, export.size_rows(RECORD)),
    ):
        assert [row[0] for row in rows] == list(RECORD["cases"])
        assert {len(row) for row in rows} == {len(titles)}
    assert export.equality_rows(RECORD)[0][3] == "-"  # a rule has no ONNX


def test_a_missing_program_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda _: None)
    with refused("arm-none-eabi-gcc ... gcc-arm-none-eabi"):
        export.bench_export()
