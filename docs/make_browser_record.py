"""Measure the scenes of the front page in a browser: ``python docs/make_browser_record.py``.

Writes ``benchmarks/browser.json``. Needs Chromium and the extra ``dev``; a minute on one core.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

from scenes import SCENES, build

from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import write_json
from hazbot_gym.utils.json_object import JsonObject

RECORD = Path(__file__).parents[1] / "benchmarks" / "browser.json"
SECONDS = 5.0  # of each count
STEPS = """
async ([name, seconds]) => {
  await hazbot.choose(name);
  hazbot.setPlaying(false);
  const { robot, scene } = hazbot;
  const policy = hazbot.policy("policy");
  for (let warm = 0; warm < 500; warm += 1) robot.step(robot.action(policy)); // compiled by then
  const until = performance.now() + 1000 * seconds;
  let [steps, people] = [0, 0];
  while (performance.now() < until) {
    if (robot.outcome !== "running") robot.start(steps % scene.starts.length);
    robot.step(robot.action(policy));
    people += robot.people().length;
    steps += 1;
  }
  return { steps_per_s: steps / seconds, mean_people: people / steps };
}
"""
PICTURES = """
async ([name, seconds]) => {
  await hazbot.choose(name);
  hazbot.setPlaying(true);
  const until = performance.now() + 1000 * seconds;
  let pictures = 0;
  while (performance.now() < until) {
    await new Promise((done) => requestAnimationFrame(done));
    pictures += 1;
  }
  return pictures / seconds;
}
"""


def record() -> JsonObject:
    """Return the record: decisions and pictures a second of each scene, and sizes."""
    program, built = shutil.which("chromium"), build()
    with sync_playwright() as driver, tempfile.TemporaryDirectory() as folder:
        browser = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page, file = browser.new_page(), Path(folder) / "scenes.html"
        file.write_text(built.page, encoding="utf-8")
        page.goto(file.as_uri())
        page.wait_for_function("window.hazbot")
        scenes = {name: measured(page, name) for name in SCENES}
        return {
            "commit": provenance.commit(),
            "versions": provenance.versions() | {"chromium": browser.version},
            "machine": provenance.machine(),
            "bytes": built.sizes,
            "scenes": scenes,
        }


def measured(page: Page, name: str) -> dict[str, Any]:
    """Return the rates of a scene: its own policy drives, and a ghost beside it in pictures."""
    rates: dict[str, Any] = page.evaluate(STEPS, [name, SECONDS])
    return rates | {"pictures_per_s": page.evaluate(PICTURES, [name, SECONDS])}


if __name__ == "__main__":
    write_json(RECORD, record())
