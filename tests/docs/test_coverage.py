"""The simulation of coverage, and what its committed record says of the interval in use."""

from __future__ import annotations

from pathlib import Path

import make_coverage
import pytest

from hazbot_gym.utils.files import read_json

RECORD = read_json(Path(__file__).parents[2] / "benchmarks" / "coverage.json")


@pytest.mark.parametrize(("seeds", "least"), [(2, 0.88), (3, 0.91), (5, 0.92), (10, 0.93)])
def test_the_interval_in_use_covers_almost_what_it_says(seeds: int, least: float) -> None:
    cases = [case for case in RECORD["cases"] if case["seeds"] == seeds]
    assert len(cases) == 2 * len(RECORD["models"])
    assert min(case["methods"]["student"]["coverage"] for case in cases) >= least


def test_a_few_studies_show_what_the_record_says() -> None:
    model = make_coverage.MODELS["seeds dominate"]
    found = make_coverage.coverage(model, 2, 3, studies=200, resamples=200)
    assert found["student"]["coverage"] > 0.89
    assert found["percentile"]["coverage"] < 0.87
    assert set(found) == set(RECORD["cases"][0]["methods"])


def test_a_single_row_keeps_the_percentiles() -> None:
    model = make_coverage.MODELS["scenarios dominate"]
    found = make_coverage.coverage(model, 1, 1, studies=5, resamples=100)
    assert found["student"] == found["percentile"]
