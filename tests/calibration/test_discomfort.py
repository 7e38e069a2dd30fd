from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from hazbot_gym.calibration import discomfort as model
from hazbot_gym.calibration.discomfort import (
    ALL_PEOPLE,
    CHOSEN,
    VARIANTS,
    Curve,
    Variant,
    fit,
    nearness,
)
from hazbot_gym.calibration.ratings import Ratings, load_ratings
from hazbot_gym.cli import app
from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils.files import read_json

RECORD = Path(__file__).parents[2] / "benchmarks" / "discomfort.json"
TRUE = Curve(floor=0.05, contact_m=0.4, length_m=0.8, direction=0.3)


def rated(
    curve: Curve,
    variant: Variant = CHOSEN,
    *,
    raters: int = 4,
    each: int = 200,
    noise: float = 0.05,
) -> Ratings:
    """Return ratings of people with the same curve, up to noise."""
    rng, size = np.random.default_rng(0), raters * each
    distance_m = np.sort(rng.uniform(0.2, 4.0, (size, 3)))
    facing = np.cos(rng.uniform(-np.pi, np.pi, (size, 3)))
    truth = variant.discomfort(curve, distance_m, facing)
    return Ratings(
        discomfort=np.clip(truth + rng.normal(0.0, noise, size), 0.0, 1.0),
        raters=np.repeat([f"r{i}" for i in range(raters)], each),
        people=np.full(size, 3),
        distance_m=distance_m,
        facing=facing,
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with two ratings of three people."""
    (tmp_path / "ratings.csv").write_text("sample,rater,score,humans\n7,a,80,2\n8,b,100,0\n")
    (tmp_path / "humans.csv").write_text(
        "sample,human,x_m,y_m,yaw_deg\n7,1,2.0,0.0,-90\n7,2,0.0,1.0,180\n"
    )
    return tmp_path


def test_people_are_read_with_the_nearest_first(folder: Path) -> None:
    ratings = load_ratings(folder)
    assert ratings.discomfort.tolist() == pytest.approx([0.2, 0.0])
    assert ratings.people.tolist() == [2, 0]
    assert ratings.distance_m.tolist() == [[1.0, 2.0], [np.inf, np.inf]]
    # The person at (0, 1) looks along (0, 1), away from the robot; that at (2, 0) looks at it.
    assert ratings.facing[0] == pytest.approx([-1.0, 1.0])


@pytest.mark.parametrize(
    ("file", "text", "named"),
    [
        ("ratings.csv", None, "ratings.csv"),
        ("ratings.csv", "sample,rater,score\n", "no rows"),
        ("ratings.csv", "sample,rater\n1,a\n", "'score'"),
        ("ratings.csv", "sample,rater,score\n1,a,50\n1,b,60\n", "twice"),
        ("ratings.csv", "sample,rater,score\n7,a,120\n", "'120'"),
        ("ratings.csv", "sample,rater,score\n7,a\n", "score"),
        ("humans.csv", None, "humans.csv"),
        ("humans.csv", "sample,human,x_m,y_m\n", "'yaw_deg'"),
        ("humans.csv", "sample,human,x_m,y_m,yaw_deg\n7,1,2.0,nan,0\n", "y_m"),
        ("humans.csv", "sample,human,x_m,y_m,yaw_deg\n9,1,2.0,0,0\n", "'9'"),
    ],
)
def test_unusable_table_is_one_line(folder: Path, file: str, text: str | None, named: str) -> None:
    if text is None:
        (folder / file).unlink()
    else:
        (folder / file).write_text(text)
    with pytest.raises(InvalidInput) as caught:
        load_ratings(folder)
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def test_fit_recovers_the_constants() -> None:
    found = fit(rated(TRUE))
    assert found == pytest.approx(TRUE, abs=0.02)


def test_raters_count_alike_whatever_they_rated() -> None:
    many, few = rated(TRUE, raters=1, each=3000), rated(TRUE._replace(length_m=0.4), raters=1)
    few = few._replace(raters=np.full(len(few.raters), "other"))
    both = Ratings(*(np.concatenate(columns) for columns in zip(many, few, strict=True)))
    assert fit(both).length_m == pytest.approx(0.6, abs=0.06)


@pytest.mark.parametrize("true", [VARIANTS[1], ALL_PEOPLE, CHOSEN])
def test_true_variant_has_the_least_error_on_other_raters(true: Variant) -> None:
    curve = TRUE._replace(others=float(true is ALL_PEOPLE))
    ratings = rated(curve, true, noise=0.01)
    errors = {each: model.error_on_others(ratings, each) for each in VARIANTS}
    assert errors[true] <= 1.01 * min(errors.values())
    assert errors[VARIANTS[0]] > 1.1 * errors[true]


def test_nearness_falls_with_distance_and_behind() -> None:
    distance_m = np.linspace(0.0, 6.0, 100)
    front, behind = (nearness(TRUE, distance_m, np.full(100, c)) for c in (1.0, -1.0))
    for each in (front, behind):
        assert each[0] == 1.0
        assert np.all(np.diff(each) <= 0.0)
    assert np.all(front >= behind)


def test_report_has_intervals_around_its_values() -> None:
    record = model.report(rated(TRUE, noise=0.2), draws=30)
    for row in record["bounds"]:
        low, high = row["front"]["interval"]
        assert low < row["front"]["value"] < high
    assert record == model.report(rated(TRUE, noise=0.2), draws=30)
    with pytest.raises(InvalidInput, match="2 raters"):
        model.report(rated(TRUE, raters=2), draws=2)


def test_record_is_the_fit_of_the_ratings(tracks_dir: Path) -> None:
    ratings = load_ratings(tracks_dir / "proximity_ratings")
    record = read_json(RECORD)
    assert record["ratings"] == len(ratings.discomfort)
    assert fit(ratings)._asdict() == pytest.approx(record["curve"], rel=1e-4)


def test_command_fits_one_kind_of_data(tracks_dir: Path, tmp_path: Path) -> None:
    for words, named in (
        (["calibrate"], "no data"),
        (["calibrate", "--ratings", "a", "--tracks", "b"], "--tracks and --ratings"),
        (["calibrate", "--ratings", "a", "--fit", "b"], "--fit"),
        (["calibrate", "--ratings", str(tmp_path)], "ratings.csv"),
    ):
        result = CliRunner().invoke(app, words)
        assert result.exit_code == 2
        assert named in result.output
