from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from paper_page import page as docs_page

from hazbot_gym.paper import run
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.numbers import reported
from hazbot_gym.paper.page import make_page
from hazbot_gym.paper.tables import basis_rows, summary_line
from hazbot_gym.utils.files import read_json
from tests.refusals import refused

SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 1"><rect width="2" height="1"/></svg>'


def chapters() -> list[Chapter]:
    """Return two chapters with a value for every number, one of them far off."""
    here = {n: each.paper for n, each in reported().numbers.items() if each.rule != "absent"}
    first, second = dict(list(here.items())[:20]), dict(list(here.items())[20:])
    second["circle_pid_position_max_m"] = 0.142
    table = Table("Plants & <motors>", ("plant", "error [m]"), [("A", 0.08765), ("B", None)])
    return [
        Chapter("2", "Design", first, {}, ("One <b>.",)),
        Chapter(
            "3",
            "Rest",
            second,
            {"wins": 0.44},
            ("Two.",),
            (table,),
            (Picture("it", "F", "c", SVG),),
        ),
    ]


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let chapters be made without running anything."""
    monkeypatch.setattr(run, "run_chapters", lambda **_: chapters())


def test_a_run_leaves_record_page_and_pictures(tmp_path: Path, fake: None) -> None:
    record = run.reproduce(tmp_path / "new", quick=True)
    assert read_json(tmp_path / "new" / "paper.json") == record
    assert (tmp_path / "new" / "figures" / "it.svg").read_text(encoding="utf-8") == SVG
    page = (tmp_path / "new" / "paper.html").read_text(encoding="utf-8")
    assert 'id="section-3"' in page
    # That one, the three bounds, which are not met by their own value, and the two that are absent.
    assert record["verdicts"]["not reproduced"] == 1 + 3 + 2
    assert record["verdicts_by_basis"]["predicted"]["not reproduced"] == 1 + 1
    assert record["chapters"]["3"] == {"wins": 0.44}


def test_verdicts_by_basis_are_the_same_from_the_file_as_from_the_run(
    tmp_path: Path, fake: None
) -> None:
    record = run.reproduce(tmp_path, quick=True)
    rows = basis_rows(record)
    assert [row[0] for row in rows] == ["taken over", "fitted", "predicted"]
    assert [int(row[1]) for row in rows] == [sum(map(int, row[2:])) for row in rows]
    assert sum(int(row[2]) for row in rows) == record["verdicts"]["reproduced"]
    assert basis_rows(run.read(tmp_path)) == rows
    assert summary_line(run.read(tmp_path)) == summary_line(record)


def test_results_of_the_same_code_are_kept_and_of_other_code_not_replaced_unasked(
    tmp_path: Path, fake: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    record = run.reproduce(tmp_path, quick=True)
    monkeypatch.setattr(run, "run_chapters", lambda **_: pytest.fail("it was there already"))
    assert run.reproduce(tmp_path, quick=True) == record
    with refused("--force"):
        run.reproduce(tmp_path, quick=False)
    monkeypatch.setattr(run, "run_chapters", lambda **_: chapters())
    assert run.reproduce(tmp_path, quick=False, is_replacing=True)["form"] == "full"


def test_a_killed_run_is_run_again_and_foreign_files_are_left_alone(
    tmp_path: Path, fake: None
) -> None:
    run.reproduce(tmp_path / "killed", quick=True)
    (tmp_path / "killed" / "paper.html").unlink()
    run.reproduce(tmp_path / "killed", quick=True)
    assert (tmp_path / "killed" / "paper.html").exists()
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("")
    with refused("no paper's"):
        run.reproduce(tmp_path / "mine", is_replacing=True)


def page_of(found: list[Chapter]) -> str:
    return make_page(run.record_of(found, "quick x", quick=True), found)


def test_page_escapes_what_it_is_filled_with_and_shows_every_number() -> None:
    page = page_of(chapters())
    assert "One &lt;b&gt;." in page
    assert "Plants &amp; &lt;motors&gt;" in page
    assert "0.0877" in page  # three digits that count
    for each in reported().numbers.values():
        assert each.where in page


def test_docs_page_tells_what_did_not_come_out() -> None:
    record: dict[str, Any] = run.record_of(chapters(), "quick x", quick=True)
    text = docs_page(
        "$record\n$summary\n$bases\n$missed\n$findings\n$people\n$lines\n$numbers",
        record,
        name="paper.json",
        calibration={"runs": []},
    )
    assert "(section 5.2, Figure 20a) | 0.1 m | 0.142 |" in text
    assert "| < 0.098 m |" in text
    assert text.count("| not reproduced |") == 2 * 6 + 1  # there, among all, and as a head
    assert "`core.tracking:pose_error`" in text


@pytest.mark.parametrize(("width", "height"), [(1280, 900), (390, 844)])
def test_page_opens_in_a_browser_and_fits(
    browser: Any, tmp_path: Path, width: int, height: int
) -> None:
    path = tmp_path / "paper.html"
    path.write_text(page_of(chapters()), encoding="utf-8")
    browser.open(path, width, height)
    wide, seen, pictures = browser.run("""
        return [
          document.documentElement.scrollWidth,
          document.documentElement.clientWidth,
          [...document.images].map((image) => image.naturalWidth),
        ];
    """)
    assert wide == seen <= width
    assert pictures
    assert min(pictures) > 0
    assert browser.complaints == []
