"""The page of a study with fronts and an oracle, on the page and in a real browser."""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.study.config import load_study
from hazbot_gym.study.report import page as report
from hazbot_gym.study.run import run_study
from tests.study.report.test_page import plots_of

STUDY = load_study(
    policies=["fuzzy_expert", "constant:0.5", "constant:0.3", "stop_on_sight"],
    shown=["fuzzy_expert", "constant:0.5"],
    sets=["bank:test/Crossing", "bank:test/Leading", "E*"],
    episodes=4,
    resamples=100,
    fronts={
        "sets": ["test"],
        "groups": {"slow": ["constant:0.5", "constant:0.3"], "careful": ["fuzzy_expert"]},
    },
    oracle={"sets": ["test"], "episodes": 2, "worlds": 8, "rounds": 1},
)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> report.Study:
    out = tmp_path_factory.mktemp("oracle") / "out"
    run_study(STUDY, out, workers=1, command="hazbot study --config mine.yaml")
    return report.read(out)


@pytest.fixture(scope="module")
def page(study: report.Study) -> str:
    return report.make_page(study)


def test_sets_of_the_bank_are_pooled_by_group_and_come_first(study: report.Study) -> None:
    assert list(report.all_blocks(study)) == ["test", "test/Crossing", "test/Leading", "E*"]
    assert report.all_blocks(study)["test"]["fuzzy_expert"]["episodes"] == 8


def test_families_are_drawn_with_their_own_fronts(study: report.Study, page: str) -> None:
    plots = plots_of(page)["families"]
    assert list(plots) == ["together", "test/Crossing", "test/Leading"]
    line, points, *_ = plots["together"]["data"]
    assert line["name"] == points["name"] == "careful"
    found = study.summary["fronts"]["together"]["careful"]["points"]
    times = [each["delay_s"]["mean"] for each in found]
    assert points["x"] == times
    assert set(line["x"]) <= set(times)


def test_the_best_drive_is_no_worse_than_anybody(study: report.Study, page: str) -> None:
    searched = study.summary["oracle"]["searched"]
    assert searched["episodes"] == 4
    for found in searched["policies"].values():
        assert found["regret"]["mean"] >= 0.0
    assert list(plots_of(page)["beside"]) == ["test/Crossing", "test/Leading"]
    names = [trace["name"] for trace in plots_of(page)["beside"]["test/Crossing"]["data"]]
    assert names == ["oracle", "fuzzy_expert", "constant:0.5"]


def test_only_who_is_shown_is_replayed_but_all_are_in_the_tables(page: str) -> None:
    text = html.unescape(page)
    replayed = re.search(r'<select class="policy">(.*?)</select>', text, re.DOTALL)
    assert replayed is not None
    assert "constant:0.5" in replayed[1]
    assert "stop_on_sight" not in replayed[1]
    assert "stop_on_sight" in text


def test_everybodys_worst_episode_can_be_seen(study: report.Study) -> None:
    rows = study.rows[study.rows["scenario_set"] == "test/Leading"]
    some = study.replays.chosen["test/Leading"]
    mine = rows[rows["policy"] == "constant:0.5"]
    worst = int(mine["episode"].loc[mine["return"].idxmin()])
    (found,) = [each for each in some if each.number == worst]
    assert "worst of" in found.why
    assert "constant:0.5" in found.why


def test_the_page_says_by_which_command_and_what_it_took(page: str) -> None:
    assert "hazbot study --config mine.yaml" in page
    assert "shards of episodes" in page


def test_a_browser_draws_all_of_it(browser: Any, page: str, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    path.write_text(page, encoding="utf-8")
    for width in (1280, 390):
        browser.open(path, width, 900)
        counts = browser.run(
            """
            const wait = (ms) => new Promise((done) => setTimeout(done, ms));
            while (!document.documentElement.dataset.plots) await wait(20);
            for (const select of document.querySelectorAll("select.set")) {
              for (const option of [...select.options]) {
                select.value = option.value;
                select.dispatchEvent(new Event("change"));
              }
            }
            await wait(100);
            const drawn = (name) =>
              document.querySelectorAll(`[data-plot="${name}"] .trace`).length;
            return [drawn("families"), drawn("beside"), document.documentElement.scrollWidth];
            """
        )
        assert counts[0] == 4  # a line and points, for two families
        assert counts[1] == 3
        assert counts[2] <= width
        assert browser.complaints == []
