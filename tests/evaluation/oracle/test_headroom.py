from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from hazbot_gym.cli import app
from hazbot_gym.config import make_config
from hazbot_gym.evaluation.oracle import headroom
from hazbot_gym.evaluation.oracle.headroom_report import family_rows
from hazbot_gym.policies.sweeps import sweep
from hazbot_gym.utils.files import read_json
from tests.refusals import says

RECORD = Path(__file__).parents[3] / "benchmarks" / "headroom.json"
SHORT: dict[str, Any] = {"place_options": {"length_m": 5.0}, "max_episode_steps": 250}


@pytest.mark.parametrize("name", ["Crossing-v0", "Leading-v0"])
def test_the_optimum_bounds_every_policy(name: str) -> None:
    config, episodes = make_config(headroom.headroom_config(name), **SHORT), 3
    _, keys = headroom.play(config, "constant:1.0", episodes)
    best = headroom.best_returns(config, keys)
    specs = [spec for family in ("constant", *headroom.RULES) for spec in sweep(family)[::6]]
    for spec in [*specs, "fuzzy_expert"]:
        played, met = headroom.play(config, spec, episodes)
        assert met == keys
        assert np.all(played.returns <= best + 1e-6), spec


def test_commands_are_rounded_to_the_lattice() -> None:
    policy = headroom.OnLattice(headroom.make("constant:0.33"))
    actions, _ = policy.predict(np.zeros((2, 48), np.float32))
    np.testing.assert_allclose(actions, 2.0 * 0.3 - 1.0, atol=1e-6)


def test_four_or_more_environments_have_room() -> None:
    record = read_json(RECORD)
    assert set(record["environments"]) == set(headroom.environments())
    rooms = [found["room"] >= record["enough"] for found in record["environments"].values()]
    assert sum(rooms) >= 4


def test_shares_run_from_the_best_constant_to_the_optimum() -> None:
    record = read_json(RECORD)
    assert len(family_rows(record)) == 7 * len(record["environments"])
    for found in record["environments"].values():
        assert found["families"]["constant"]["share"] == 0.0
        assert found["room"] <= 1.0
        assert all(row["share"] <= 1.0 for row in found["families"].values())


def test_an_unknown_environment_is_one_line() -> None:
    result = CliRunner().invoke(app, ["headroom", "--env", "Replay-v0"])
    assert result.exit_code == 2
    says(result.output, "'Replay-v0' ... Corridor-v0")
