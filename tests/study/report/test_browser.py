"""The page in a real browser: whatever can be clicked is clicked, and nothing may complain."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.study.report import maps
from hazbot_gym.study.report import page as report

HELPERS = """
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const until = async (is) => {
  for (let k = 0; k < 3000 && !is(); k += 1) await wait(20);
  if (!is()) throw new Error(`never: ${is}`);
};
const ready = async () => {
  const { dataset } = document.documentElement;
  await until(() => dataset.plots && dataset.tables);
};
const player = document.getElementById("player");
const play = document.getElementById("play");
const choose = (select, value) => {
  select.value = value;
  select.dispatchEvent(new Event("change"));
};
const state = () => ({
  time: parseFloat(document.getElementById("clock").textContent),
  pictures: [...player.querySelectorAll("canvas")].map((canvas) => canvas.toDataURL()),
});
const traces = (plot) => document.querySelectorAll(`[data-plot="${plot}"] .trace`).length;
"""


def run(browser: Any, script: str) -> Any:
    """Run a script on the page, which may use the names of ``HELPERS``."""
    return browser.run(f"{HELPERS} await ready(); {script}")


@pytest.fixture(scope="module")
def page(finished: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("browser") / "report.html"
    path.write_text(report.make_page(report.read(finished)), encoding="utf-8")
    return path


def test_a_complaint_is_heard(browser: Any, tmp_path: Path) -> None:
    broken = tmp_path / "broken.html"
    broken.write_text("<script>console.error('first'); nowhere();</script>")
    browser.open(broken, 1280, 900)
    assert "first" in browser.complaints[0]
    assert "nowhere is not defined" in browser.complaints[1]


def test_a_replay_plays_and_pauses(browser: Any, page: Path) -> None:
    browser.open(page, 1280, 900)
    before, after, paused = run(
        browser,
        """
        await until(() => !player.hidden);
        const states = [state()];
        choose(document.getElementById("rate"), "10");
        play.click();
        await until(() => state().time >= 3);
        play.click();
        states.push(state());
        await wait(200);
        return [...states, state()];
    """,
    )
    assert before["time"] == 0.0
    assert after["time"] >= 3.0
    assert len(before["pictures"]) == 4  # two maps, speed, reward
    assert not set(before["pictures"]) & set(after["pictures"])
    assert paused == after
    assert browser.complaints == []


def test_scrubbing_to_the_end_shows_how_it_ended(browser: Any, page: Path) -> None:
    browser.open(page, 1280, 900)
    ends = run(
        browser,
        """
        await until(() => !player.hidden);
        const scrub = document.getElementById("scrub");
        scrub.value = scrub.max;
        scrub.dispatchEvent(new Event("input"));
        return [...player.querySelectorAll(".end")].map((end) => end.textContent);
    """,
    )
    assert len(ends) == 2
    assert all(re.search(r" at \d+\.\d s$", end) for end in ends), ends
    assert browser.complaints == []


def test_every_choice_can_be_made_and_holds_for_the_whole_page(browser: Any, page: Path) -> None:
    browser.open(page, 1280, 900)
    sets = run(
        browser,
        """
        await until(() => !player.hidden);
        const selects = [...document.querySelectorAll("select:not(#rate)")];
        for (const select of selects) {
          for (const option of [...select.options]) choose(select, option.value);
        }
        await wait(100);
        return [...document.querySelectorAll("select.set")].map((select) => select.value);
    """,
    )
    assert sets == ["Corridor"] * 4
    assert browser.complaints == []


KEY = """
const names = [...document.querySelectorAll(".plot")].map((div) => div.dataset.plot);
const rows = () => [...document.querySelectorAll("#results tbody tr")]
  .filter((row) => row.offsetParent).length;
const counts = () => [...names.map(traces), rows()];
const all = document.querySelector(".key .all");
const changed = (before) => until(() => counts().join() !== before.join());
"""


def test_every_plot_is_drawn_and_the_key_hides_a_policy_in_all(browser: Any, page: Path) -> None:
    browser.open(page, 1280, 900)
    before, after = run(
        browser,
        KEY
        + """
        const before = counts();
        document.querySelector(".key button").click();
        await changed(before);
        return [before, counts()];
    """,
    )
    assert len(before) == 5  # front, speed in E*, distance, clearance; rows of the first table
    assert all(count >= 4 for count in before)
    assert after == [count - 1 for count in before]
    assert browser.complaints == []


def test_few_policies_are_shown_until_all_are_asked_for(
    browser: Any, finished: Path, tmp_path: Path
) -> None:
    study = report.read(finished)
    summary = {**study.summary, "default_policies": ["fuzzy_expert", "stop_on_sight"]}
    path = tmp_path / "few.html"
    path.write_text(report.make_page(study._replace(summary=summary)), encoding="utf-8")
    browser.open(path, 1280, 900)
    few, more, every, again, saved = run(
        browser,
        KEY
        + """
        const states = [counts()];
        const away = document.querySelector('.key [data-name][aria-pressed="false"]');
        for (const button of [away, all, all]) {
          button.click();
          await changed(states.at(-1));
          states.push(counts());
        }
        const link = document.querySelector("#results .save");
        link.addEventListener("click", (event) => event.preventDefault());
        const saved = new Promise((done) => {
          URL.createObjectURL = (blob) => { done(blob.text()); return ""; };
        });
        link.click();
        return [...states, await saved];
    """,
    )
    assert few == again == [3, 2, 2, 2, 2]  # and the line of the constant speeds
    assert more == [count + 1 for count in few]
    assert every == [count + 2 for count in few]
    assert len(saved.splitlines()) == 5
    assert browser.complaints == []


def test_plots_have_the_colors_of_the_theme(browser: Any, page: Path) -> None:
    def colors(scheme: str) -> Any:
        browser.page.emulate_media(color_scheme=scheme)
        browser.open(page, 1280, 900)
        return run(
            browser,
            """
            const line = document.querySelector('[data-plot="distance"] .lines path');
            const swatch = document.querySelector(".key .swatch");
            return [getComputedStyle(line).stroke, getComputedStyle(swatch).color];
        """,
        )

    light, dark = colors("light"), colors("dark")
    assert light == ["rgb(10, 77, 168)"] * 2
    assert dark == ["rgb(140, 184, 255)"] * 2
    assert browser.complaints == []


def test_a_phone_shows_everything_without_scrolling_sideways(browser: Any, page: Path) -> None:
    browser.open(page, 390, 844)
    wide, seen, plots = run(
        browser,
        """
        await until(() => !player.hidden);
        const svgs = [...document.querySelectorAll(".plot .main-svg")];
        return [
          document.documentElement.scrollWidth,
          document.documentElement.clientWidth,
          svgs.map((svg) => svg.getBoundingClientRect().right),
        ];
    """,
    )
    assert wide == seen <= 390
    assert max(plots) <= seen
    assert browser.complaints == []


def test_every_person_of_the_gallery_has_the_color_of_an_episode(browser: Any, page: Path) -> None:
    browser.open(page, 1280, 900)
    fills, strokes = run(
        browser,
        """
        const styles = (what, property) => [...new Set(
          [...document.querySelectorAll(`.episode ${what}`)]
            .map((e) => getComputedStyle(e)[property]),
        )];
        return [styles("circle", "fill"), styles("polyline", "stroke")];
    """,
    )
    assert set(fills) == set(strokes)
    assert 1 < len(fills) <= len(maps.HUES)
    assert "rgb(0, 0, 0)" not in fills


def test_tables_are_sorted_by_a_click_on_a_title_and_saved_as_csv(browser: Any, page: Path) -> None:
    browser.open(page, 1280, 900)
    down, up, saved = run(
        browser,
        """
        const table = document.querySelector("#results table");
        const values = () => [...table.tBodies[0].rows]
          .map((row) => parseFloat(row.cells[row.cells.length - 1].firstChild.textContent));
        const title = [...table.tHead.rows[0].cells].pop().querySelector("button");
        title.click();
        const down = values();
        title.click();
        const link = document.querySelector("#results .save");
        link.addEventListener("click", (event) => event.preventDefault());
        link.click();
        return [down, values(), link.href];
    """,
    )
    assert len(down) == 4
    assert down == sorted(down, reverse=True) != up
    assert up == sorted(up)
    assert saved.startswith("blob:")
    assert browser.complaints == []


def test_space_and_arrow_keys_drive_the_player(browser: Any, page: Path) -> None:
    browser.open(page, 1280, 900)
    start, later, label = run(
        browser,
        """
        await until(() => !player.hidden);
        player.focus();
        const press = (key) => document.activeElement.dispatchEvent(
          new KeyboardEvent("keydown", { key, bubbles: true }),
        );
        const start = state().time;
        for (let k = 0; k < 5; k += 1) press("ArrowRight");
        press("ArrowLeft");
        const later = state().time;
        press(" ");
        return [start, later, play.textContent];
    """,
    )
    assert (start, later, label) == (0.0, 0.4, "Pause")
    assert browser.complaints == []
