from __future__ import annotations

import base64
import html
import json
import re
import zlib
from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.study import store
from hazbot_gym.study.config import StudyConfig, load_study
from hazbot_gym.study.headline import IN_DISTRIBUTION, POOLED, headline
from hazbot_gym.study.report import figures
from hazbot_gym.study.report import page as report
from hazbot_gym.study.report.style import styles
from hazbot_gym.study.run import run_study
from hazbot_gym.study.summary import LEVELS
from hazbot_gym.utils import files
from tests.refusals import refused

FILES = (store.MANIFEST, store.SUMMARY, store.EPISODES, store.REPLAYS, store.COSTS)


@pytest.fixture(scope="module")
def study(finished: Path) -> report.Study:
    return report.read(finished)


@pytest.fixture(scope="module")
def page(study: report.Study) -> str:
    return report.make_page(study)


def plots_of(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="text/plain" id="plot-data">(.*?)</script>', page)
    assert found is not None
    plots: dict[str, Any] = json.loads(zlib.decompress(base64.b64decode(found[1])))
    return plots


def test_the_page_is_one_file_that_names_no_other(page: str) -> None:
    library = figures.library()
    own = page.replace(library, "")
    assert len(own) < len(page)
    assert "https:" not in own
    assert "http:" not in own
    assert not re.search(r"""(?:src|href)\s*=\s*["'](?!#)""", own)
    assert len(page) < 3_000_000


def test_the_page_is_the_same_for_the_same_study(study: report.Study, page: str) -> None:
    assert report.make_page(study) == page


def test_the_page_says_what_was_run(study: report.Study, page: str) -> None:
    text = html.unescape(page)
    assert study.manifest["study"] in text
    assert study.manifest["versions"]["numpy"] in text
    for policy in study.config.policies:
        assert policy in text


def test_every_set_is_in_every_plot_that_can_choose(page: str) -> None:
    plots = plots_of(page)
    assert list(plots["front"]) == [IN_DISTRIBUTION, POOLED, "E*", "Crossing", "Corridor"]
    assert list(plots["clearance"]) == list(plots["front"])
    assert list(plots["distance"]) == ["E*", "Crossing", "Corridor"]
    assert list(plots["speed E*"]) == ["E*"]


def test_what_is_drawn_are_the_recorded_numbers(study: report.Study, page: str) -> None:
    plots = plots_of(page)
    front = {trace["name"]: trace for trace in plots["front"]["Crossing"]["data"]}
    for policy, result in study.summary["sets"]["Crossing"].items():
        metrics, trace = result["metrics"], front[policy]
        assert trace["x"] == [metrics["delay_s"]["mean"]]
        high = trace["y"][0] + trace["error_y"]["array"][0]
        assert high == pytest.approx(metrics["discomfort_s"]["high"])


def test_only_swept_policies_are_joined_to_a_front(page: str) -> None:
    joined, *points = plots_of(page)["front"]["Crossing"]["data"]
    assert joined["mode"] == "lines"
    swept = [trace for trace in points if trace["name"].startswith("constant:")]
    assert sorted(joined["x"]) == sorted(trace["x"][0] for trace in swept)


def test_the_papers_events_are_marked(page: str) -> None:
    layout = plots_of(page)["speed E*"]["E*"]["layout"]
    assert [shape["x0"] for shape in layout["shapes"]] == [1.6, 3.4]
    assert "paper: stops 3.4 s" in [note["text"] for note in layout["annotations"]]


def test_curves_of_clearance_end_at_the_share_that_ever_met_anybody() -> None:
    quantiles = [0.25] * 26 + [0.5] * 50 + [None] * 25
    some = {"a": {"clearance_quantiles_m": quantiles}}
    (trace,) = figures.clearances(some, styles(["a"]))["data"]
    assert (trace["x"][:26], trace["x"][26:]) == ([0.25] * 26, [0.5] * 50)
    assert (trace["y"][0], trace["y"][-1]) == (0.0, 0.75)


@pytest.mark.parametrize(("width", "end"), [(0.1, 0.3), (0.5, 0.4), (9.0, 2.0)])
def test_the_axis_of_clearance_ends_where_the_curves_have_risen(width: float, end: float) -> None:
    evenly = [round(width * level, 3) for level in LEVELS]
    some = {"a": {"clearance_quantiles_m": evenly}}
    layout = figures.clearances(some, styles(["a"]))["layout"]
    assert layout["xaxis"]["range"] == [-0.02, pytest.approx(end)]


def test_the_headline_is_over_what_is_in_distribution_alone(study: report.Study) -> None:
    found = headline(study.summary)
    assert (found.name, found.sets) == (IN_DISTRIBUTION, ["Crossing", "Corridor"])
    rows = study.rows[study.rows["scenario_set"] != "E*"]
    for policy, result in found.policies.items():
        mean = rows[rows["policy"] == policy]["delay_s"].mean()
        assert result["episodes"] == 8
        assert result["metrics"]["delay_s"]["mean"] == pytest.approx(mean)


def test_names_from_outside_cannot_break_the_page(study: report.Study) -> None:
    named = study.config.sets[0].model_copy(update={"name": "</script><b>&"})
    config = study.config.model_copy(update={"sets": (named, *study.config.sets[1:])})

    def renamed(blocks: dict[str, Any]) -> dict[str, Any]:
        return {named.name if name == "E*" else name: block for name, block in blocks.items()}

    manifest = {**study.manifest, "environments": renamed(study.manifest["environments"])}
    summary = {**study.summary, "sets": renamed(study.summary["sets"])}
    rows = study.rows.replace({"scenario_set": {"E*": named.name}})
    replays = study.replays._replace(chosen=renamed(study.replays.chosen))
    page = report.make_page(
        study._replace(
            config=config, manifest=manifest, summary=summary, rows=rows, replays=replays
        )
    )
    assert named.name not in page
    assert named.name in plots_of(page)["front"]


def test_the_report_is_written_beside_the_results_and_withdrawn_with_them(
    finished: Path, study: report.Study, page: str, tmp_path: Path
) -> None:
    for name in FILES:
        (tmp_path / name).write_bytes((finished / name).read_bytes())
    path = report.write_report(tmp_path)
    assert path == tmp_path / "report.html"
    assert path.read_text(encoding="utf-8") == page
    assert not list(tmp_path.glob(".*"))
    store.withdraw(tmp_path)
    assert not path.exists()


@pytest.mark.parametrize("missing", FILES[:4])
def test_a_study_that_is_not_finished_has_no_report(
    finished: Path, missing: str, tmp_path: Path
) -> None:
    for name in set(FILES) - {missing}:
        (tmp_path / name).write_bytes((finished / name).read_bytes())
    with refused("no finished study"):
        report.write_report(tmp_path)
    assert not (tmp_path / store.REPORT).exists()


def test_a_summary_without_pareto_standings_is_of_another_version(
    finished: Path, tmp_path: Path
) -> None:
    for name in FILES:
        (tmp_path / name).write_bytes((finished / name).read_bytes())
    summary = files.read_json(tmp_path / store.SUMMARY)
    for each in summary["sets"]["Crossing"].values():
        del each["dominated_by"]
    files.write_json(tmp_path / store.SUMMARY, summary)
    with refused("hazbot study"):
        report.read(tmp_path)


def block(*intrusions: float) -> dict[str, Any]:
    """Return a set's summary of policies that differ in intrusion."""
    axes = [{"delay_s": 1.4, "discomfort_s": value} for value in intrusions]
    return {
        name: {
            "metrics": {axis: dict.fromkeys(("mean", "low", "high"), v) for axis, v in of.items()},
            "dominated_by": [],
        }
        for name, of in zip("abc", axes, strict=False)
    }


@pytest.mark.parametrize(
    ("intrusions", "kind"),
    [((0.02, 0.03), None), ((0.02, 0.03, 1.4), "log"), ((0.0, 0.03, 1.4), None)],
)
def test_intrusions_far_apart_are_told_apart(intrusions: Any, kind: str | None) -> None:
    some = block(*intrusions)
    figure = figures.front(some, styles(list(some)))
    assert figure["layout"]["yaxis"].get("type") == kind


def test_dominated_policies_are_hollow() -> None:
    some = block(0.02, 0.03)
    some["b"]["dominated_by"] = ["a"]
    marks = [trace["marker"]["symbol"] for trace in figures.front(some, styles(list(some)))["data"]]
    assert [mark.endswith("-open") for mark in marks] == [False, True]


def test_a_policy_without_intervals_is_drawn() -> None:
    some = block(0.02)
    for estimate in some["a"]["metrics"].values():
        estimate |= {"low": None, "high": None}
    (point,) = figures.front(some, styles(["a"]))["data"]
    assert (point["x"], point["y"]) == ([1.4], [0.02])
    assert (point["error_y"]["array"], point["error_y"]["arrayminus"]) == ([0.0], [0.0])


def test_a_study_of_one_episode_in_which_nobody_arrives_has_a_report(tmp_path: Path) -> None:
    study = load_study(
        policies=["constant:0.1"], sets=["Crossing"], episodes=1, resamples=100, seed=3
    )
    run_study(study, tmp_path / "out", workers=1)
    page = report.make_page(report.read(tmp_path / "out"))
    own = html.unescape(page.replace(figures.library(), ""))
    assert "1 scenario" in own
    assert not re.search(r">(nan|None|inf|\? to \?)", own)


def test_scenarios_are_counted_whatever_the_seeds_of_the_first_policy(study: report.Study) -> None:
    crossing = study.summary["sets"]["Crossing"]
    crossing = {
        name: {**each, "episodes": 5 * each["episodes"], "training_seeds": 5}
        for name, each in crossing.items()
    }
    summary = {**study.summary, "sets": {**study.summary["sets"], "Crossing": crossing}}
    tables = report.make_tables(study, report.all_blocks(study._replace(summary=summary)))
    assert [episodes for _, _, episodes in tables["tables"].values()] == [8, 9, 1, 4, 4]


def test_what_differs_in_a_set_is_said_in_the_words_of_its_config() -> None:
    blind = {"gain": 1.0, "range_m": 0.0}
    changed = {
        "tier": "sonar",
        "people": {"reactions": [blind] * 4},
        "sensors": {"a": {"b": [1, 2]}},
    }
    found = ScenarioSet(name="x", env="hazbot_gym/Crossing-v1", overrides=changed)
    assert report.describe(found).endswith(
        "Changed: tier = sonar, all people.reactions: gain = 1.0, range_m = 0.0, "
        "sensors.a.b = [1, 2]."
    )


def test_every_default_set_is_described() -> None:
    for scenarios in StudyConfig().all_sets:
        assert report.describe(scenarios).endswith(".")
