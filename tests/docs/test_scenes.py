"""The recorded scenes of the front page play in a browser, also from disk."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("sphinx", reason="needs the extra docs")
from scenes import SCENES, page  # type: ignore[import-not-found]  # docs/_ext


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scenes") / "scenes.html"
    path.write_text(page(), encoding="utf-8")
    return path


def test_every_scene_plays_and_can_be_scrubbed(browser: Any, file: Path) -> None:
    browser.open(file, 900, 430)
    times, ends = browser.run(
        """
        const wait = (ms) => new Promise((done) => setTimeout(done, ms));
        const told = document.getElementById("told");
        const scrub = document.getElementById("scrub");
        const [times, ends] = [[], []];
        for (const button of document.getElementById("scenes").children) {
          button.click();
          await wait(600);
          times.push(parseFloat(told.textContent));
        }
        for (const button of document.getElementById("scenes").children) {
          button.click();
          scrub.value = scrub.max;
          scrub.dispatchEvent(new Event("input"));
          await wait(100);
          ends.push(told.textContent.split(", ")[2]);
        }
        return [times, ends];
        """
    )
    assert len(times) == len(SCENES)
    assert all(0.0 < time < 3.0 for time in times)
    assert ends == ["arrived"] * len(SCENES)
    assert browser.complaints == []
    assert file.stat().st_size < 1_500_000
