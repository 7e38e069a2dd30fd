from __future__ import annotations

import json

import numpy as np
import pytest

from hazbot_gym.bench import latency
from hazbot_gym.runtime.controller import SpeedController


def test_a_case_has_its_times_in_order(capsys: pytest.CaptureFixture[str]) -> None:
    latency.main("constant", "sonar", "50")
    found = json.loads(capsys.readouterr().out)
    assert 0.0 < found["p50_ms"] <= found["p99_ms"] <= found["max_ms"]
    assert found["ready_s"] > 0.0
    assert found["first_ms"] > 0.0


def test_drawn_readings_can_be_used() -> None:
    rng, controller = np.random.default_rng(1), SpeedController("constant", clock=lambda: 0.0)
    for _ in range(50):
        controller.step(**latency.draw(rng, 4))
        assert controller.stop is None


def test_the_record_has_a_row_for_every_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(latency, "CASES", latency.CASES[:1])
    record = latency.bench_latency(20)
    (row,) = latency.rows(record)
    assert row[:2] == ("constant", "sonar")
    assert len(row) == len(latency.TITLES)
    assert json.loads(json.dumps(record)) == record
