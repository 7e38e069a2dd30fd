from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from hazbot_gym.calibration import fit
from hazbot_gym.calibration.fit import Run, load_runs, loss, split, walk_again
from hazbot_gym.cli import app
from hazbot_gym.config import Speeds
from hazbot_gym.core.social_force import HELBING_MOLNAR_1995, SocialForce
from hazbot_gym.utils.files import read_json
from tests.refusals import refused

RECORD = Path(__file__).parents[2] / "benchmarks" / "calibration.json"

pytestmark = pytest.mark.filterwarnings(  # the folder may hold files of other kinds
    "ignore:not read:hazbot_gym.errors.DoubtfulRecording"
)


@pytest.fixture(scope="module")
def runs(tracks_dir: Path) -> dict[str, Run]:
    return load_runs(tracks_dir)


def test_the_shipped_constants_are_those_of_the_record() -> None:
    record = read_json(RECORD)
    shipped = {name: getattr(SocialForce(), name) for name in fit.BOUNDS}
    assert record["fitted"] == record["shipped"] == shipped


def test_the_model_walks_as_fast_as_people_it_was_not_fitted_on(runs: dict[str, Run]) -> None:
    for name in ("bot-300-085-085", "uo-050-180-180", "boa-300-frei"):
        real, model = runs[name].real, walk_again(runs[name], SocialForce(), key=5)
        shared = real.bins.keys() & model.bins.keys()
        assert shared
        for edge in shared:
            difference = model.bins[edge].speed_mps - real.bins[edge].speed_mps
            assert abs(difference) <= fit.GOAL_MPS, (name, edge)


def test_the_shipped_constants_lose_least(runs: dict[str, Run]) -> None:
    shipped = SocialForce()
    weaker = shipped._replace(person_strength_mps2=0.5 * shipped.person_strength_mps2)
    wider = shipped._replace(person_range_m=3.0 * shipped.person_range_m)
    on = [runs[name] for name in fit.FITTED_ON]
    least = sum(loss(run, shipped) for run in on)
    for other in (weaker, wider, HELBING_MOLNAR_1995):
        assert sum(loss(run, other) for run in on) > least


def rounded(record: dict[str, Any]) -> Any:
    """Return a record without the last digits, in which versions of NumPy differ."""
    return json.loads(json.dumps(record), parse_float=lambda text: f"{float(text):.12g}")


def test_the_record_is_what_these_people_and_constants_give(runs: dict[str, Run]) -> None:
    found = fit.report(*split(runs, fit.FITTED_ON), SocialForce())
    assert rounded(found) == rounded(read_json(RECORD))


def test_speeds_can_be_drawn_instead(runs: dict[str, Run]) -> None:
    drawn = fit.with_drawn_speeds(runs["boa-300-frei"], Speeds(), seed=0)
    assert np.mean(drawn.place.entry_speeds_mps) == pytest.approx(Speeds().mean_mps, abs=0.1)


def test_the_search_finds_better_constants(
    runs: dict[str, Run], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fit, "GENERATIONS", 2)
    monkeypatch.setattr(fit, "CANDIDATES_EACH", 2)
    run, done = runs["uo-100-180-180"], []
    found = fit.fit([run], seed=1, on_progress=lambda: done.append(1))
    assert loss(run, found) < loss(run, HELBING_MOLNAR_1995)
    assert len(done) == 2
    assert found == fit.fit([run], seed=1)


def test_what_cannot_be_split(runs: dict[str, Run]) -> None:
    with refused("fit ... 'nowhere' ... boa-300-050-070"):
        split(runs, ("nowhere",))
    with refused("leaves no run to judge by"):
        split(runs, tuple(runs))


def test_a_folder_without_corridors(tracks_dir: Path) -> None:
    with refused("no recording of people in a corridor"):
        load_runs(tracks_dir / "ucy_zara01")


def test_the_command_judges_the_defaults(tracks_dir: Path, tmp_path: Path) -> None:
    file = tmp_path / "record.json"
    asked = ["calibrate", "--tracks", str(tracks_dir), "--as-shipped", "--json", str(file)]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 0, result.output
    assert "uo-180-180-120" in result.output
    assert read_json(file)["goal_mps"] == fit.GOAL_MPS


def test_a_folder_that_is_not_there() -> None:
    result = CliRunner().invoke(app, ["calibrate", "--tracks", "nowhere"])
    assert result.exit_code == 2
    assert "nowhere" in result.output
