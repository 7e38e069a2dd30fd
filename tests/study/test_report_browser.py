"""The page in a real browser: whatever can be clicked is clicked, and nothing may complain."""

from __future__ import annotations

import fcntl
import itertools
import json
import os
import re
import select
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.study import report

NAMES = ("chromium", "chromium-browser", "google-chrome")
COMPLAINTS = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")
PATIENCE_S = 120

HELPERS = """
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
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


class Browser:
    """A headless Chromium, spoken to in the DevTools protocol through pipes.

    Attributes:
        complaints: what the pages said to the console, and what went wrong in them.
    """

    def __init__(self, program: str, profile: Path) -> None:
        ours_out, theirs_in = _high_pipe()
        theirs_out, ours_in = _high_pipe()

        def connect() -> None:  # Chromium reads from 3 and writes to 4
            os.dup2(ours_out, 3)
            os.dup2(ours_in, 4)

        command = [
            program,
            *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync"),
            *("--disable-background-networking", "--disable-component-update"),
            *("--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"),
        ]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(command, preexec_fn=connect, close_fds=False, **quiet)
        os.close(ours_out)
        os.close(ours_in)
        self._write, self._read = theirs_in, theirs_out
        self._ids, self._buffer, self._session = itertools.count(1), b"", ""
        self.complaints: list[str] = []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Call a method of the protocol and return its result."""
        number = next(self._ids)
        message = {"id": number, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        answer = self._wait_for(lambda heard: heard.get("id") == number)
        assert "error" not in answer, answer
        result: dict[str, Any] = answer["result"]
        return result

    def open(self, page: Path, width: int, height: int) -> None:
        """Open a page in a window of some size and wait until it is loaded."""
        self.ask(
            "Emulation.setDeviceMetricsOverride",
            **{"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
        )
        self.ask("Page.navigate", url=page.as_uri())
        self._wait_for(lambda heard: heard.get("method") == "Page.loadEventFired")

    def run(self, script: str) -> Any:
        """Run the body of an asynchronous function on the page and return its value."""
        answer = self.ask(
            "Runtime.evaluate",
            expression=f"(async () => {{ {HELPERS} {script} }})()",
            awaitPromise=True,
            returnByValue=True,
        )
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def close(self) -> None:
        """End the browser."""
        self._process.kill()
        self._process.wait()
        os.close(self._write)
        os.close(self._read)

    def _wait_for(self, is_it: Any) -> dict[str, Any]:
        deadline = time.monotonic() + PATIENCE_S
        while True:
            while b"\0" not in self._buffer:
                left = deadline - time.monotonic()
                assert select.select([self._read], [], [], max(left, 0.0))[0], "it went silent"
                heard = os.read(self._read, 1 << 16)
                assert heard, "the browser has ended"
                self._buffer += heard
            text, _, self._buffer = self._buffer.partition(b"\0")
            message: dict[str, Any] = json.loads(text)
            if message.get("method") in COMPLAINTS:
                self.complaints.append(json.dumps(message["params"]))
            if is_it(message):
                return message


def _high_pipe() -> tuple[int, int]:
    """Return a pipe whose ends are out of the way of 3 and 4."""
    low = os.pipe()
    high = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in low]
    for end in low:
        os.close(end)
    return high[0], high[1]


@pytest.fixture(scope="module")
def page(finished: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("browser") / "report.html"
    path.write_text(report.make_page(report.read(finished)), encoding="utf-8")
    return path


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Browser]:
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip("no Chromium here: install Debian's chromium to test the page in a browser")
    browser = Browser(program, tmp_path / "profile")
    yield browser
    browser.close()


def test_a_complaint_is_heard(browser: Browser, tmp_path: Path) -> None:
    broken = tmp_path / "broken.html"
    broken.write_text("<script>console.error('first'); nowhere();</script>")
    browser.open(broken, 1280, 900)
    assert "first" in browser.complaints[0]
    assert "nowhere is not defined" in browser.complaints[1]


def test_a_replay_plays_and_pauses(browser: Browser, page: Path) -> None:
    browser.open(page, 1280, 900)
    before, after, paused = browser.run("""
        while (player.hidden) await wait(20);
        const states = [state()];
        choose(document.getElementById("rate"), "10");
        play.click();
        while (state().time < 3) await wait(20);
        play.click();
        states.push(state());
        await wait(200);
        return [...states, state()];
    """)
    assert before["time"] == 0.0
    assert after["time"] >= 3.0
    assert len(before["pictures"]) == 3
    assert not set(before["pictures"]) & set(after["pictures"])
    assert paused == after
    assert browser.complaints == []


def test_scrubbing_to_the_end_shows_how_it_ended(browser: Browser, page: Path) -> None:
    browser.open(page, 1280, 900)
    ends = browser.run("""
        while (player.hidden) await wait(20);
        const scrub = document.getElementById("scrub");
        scrub.value = scrub.max;
        scrub.dispatchEvent(new Event("input"));
        return [...player.querySelectorAll(".end")].map((end) => end.textContent);
    """)
    assert len(ends) == 2
    assert all(re.search(r" at \d+\.\d s$", end) for end in ends)
    assert browser.complaints == []


def test_every_choice_can_be_made_and_holds_for_the_whole_page(
    browser: Browser, page: Path
) -> None:
    browser.open(page, 1280, 900)
    sets = browser.run("""
        while (player.hidden) await wait(20);
        const selects = [...document.querySelectorAll("select:not(#rate)")];
        for (const select of selects) {
          for (const option of [...select.options]) choose(select, option.value);
        }
        await wait(100);
        return [...document.querySelectorAll("select.set")].map((select) => select.value);
    """)
    assert sets == ["Corridor"] * 4
    assert browser.complaints == []


def test_every_plot_is_drawn_and_the_key_hides_a_policy_in_all(
    browser: Browser, page: Path
) -> None:
    browser.open(page, 1280, 900)
    before, after = browser.run("""
        const names = [...document.querySelectorAll(".plot")].map((div) => div.dataset.plot);
        const counts = () => names.map(traces);
        const before = counts();
        document.querySelector(".key button").click();
        await wait(100);
        return [before, counts()];
    """)
    assert len(before) == 4  # front, speed in E*, distance, clearance
    assert all(count >= 4 for count in before)
    assert after == [count - 1 for count in before]
    assert browser.complaints == []


def test_a_phone_shows_everything_without_scrolling_sideways(browser: Browser, page: Path) -> None:
    browser.open(page, 390, 844)
    wide, seen, plots = browser.run("""
        while (player.hidden) await wait(20);
        const svgs = [...document.querySelectorAll(".plot .main-svg")];
        return [
          document.documentElement.scrollWidth,
          document.documentElement.clientWidth,
          svgs.map((svg) => svg.getBoundingClientRect().right),
        ];
    """)
    assert wide == seen <= 390
    assert max(plots) <= seen
    assert browser.complaints == []
