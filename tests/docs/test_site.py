"""The documentation site: it builds without a warning, no link is broken, and search finds."""

from __future__ import annotations

import fcntl
import functools
import http.server
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import urllib.parse
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import gymnasium
import pytest

from hazbot_gym import make_policy, measure, run_episode
from hazbot_gym.envs.registration import ENVIRONMENTS

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
DRAWN = DOCS / "_build" / "html" / "_animations"
NEEDED = (
    "sphinx",
    "myst_nb",
    "pyarrow",
    "stable_baselines3",
    "furo",
    "sphinx_copybutton",
    "sphinx_design",
    "pygame",
)
WIDTHS = (1440, 390)

pytestmark = pytest.mark.slow


class Links(HTMLParser):
    """Ids of a page, what it links to, and what it loads."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.ids, self.links, self.loads = set[str](), list[str](), list[str]()
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.ids |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        self.loads += [given[name] for name in ("src", "srcset") if name in given]
        if tag == "link" and given.get("rel") not in ("search", "index", "next", "prev"):
            self.loads.append(given["href"])


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the built site: $HAZBOT_SITE, or one build for all workers."""
    if built := os.environ.get("HAZBOT_SITE"):
        return ROOT / built
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"the site needs the extra docs: {', '.join(missing)} are not here")
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "site"
    folder.mkdir(exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "done").exists():
            if DRAWN.is_dir():  # by `make docs`; drawn again if the code has changed since
                shutil.copytree(DRAWN, folder / "html" / DRAWN.name, dirs_exist_ok=True)
            command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
            paths = ["-d", folder / "doctrees", DOCS, folder / "html"]
            built = subprocess.run(
                [*command, *map(str, paths)], capture_output=True, text=True, check=False, cwd=ROOT
            )
            assert built.returncode == 0, built.stderr
            (folder / "done").touch()
    return folder / "html"


@pytest.fixture(scope="module")
def server(site: Path) -> Iterator[str]:
    """Serve the site as a web server does: a page from the disk may not read the others."""

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_: Any) -> None:
            pass

    handler = functools.partial(Quiet, directory=str(site))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as running:
        threading.Thread(target=running.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{running.server_port}"
        running.shutdown()


def pages(site: Path) -> list[Path]:
    found = sorted(page for page in site.rglob("*.html") if "_static" not in page.parts)
    assert len(found) > 30
    return found


def test_no_internal_link_is_broken_and_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    read = {page.resolve(): Links(page) for page in pages(site)}
    broken = []
    for page, found in read.items():
        for link in {*found.links, *found.loads}:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme == "data":
                continue
            if parts.scheme or parts.netloc:
                if link in found.loads:
                    broken.append(f"{page.name} loads {link}")
                continue
            path = urllib.parse.unquote(parts.path)
            target = (page.parent / path).resolve() if path else page
            if not target.is_file():
                broken.append(f"{page.name}: {link}")
            elif parts.fragment and target in read and parts.fragment not in read[target].ids:
                broken.append(f"{page.name}: {link} has no such place")
    assert broken == []


def test_templates_and_scripts_of_makers_are_not_in_it(site: Path) -> None:
    assert not [page for page in site.rglob("*") if "template" in page.name]
    assert not list(site.rglob("make_*"))


def test_tutorials_are_shown_with_outputs_of_this_build(site: Path) -> None:
    notebooks = sorted((DOCS / "tutorials").glob("*.ipynb"))
    assert len(notebooks) == 3
    for notebook in notebooks:
        committed = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
        assert not any(cell.get("outputs") for cell in committed)
        page = (site / "tutorials" / f"{notebook.stem}.html").read_text(encoding="utf-8")
        assert page.count("cell_output") >= 3
        assert page.count("<img") >= 1


def test_every_environment_is_shown(site: Path) -> None:
    text = (site / "environments.html").read_text(encoding="utf-8")
    for name in ENVIRONMENTS:
        assert f'src="_animations/{name}.webp"' in text
        assert (site / "_animations" / f"{name}.webp").stat().st_size < 300_000


def test_no_page_complains_or_is_wider_than_the_window(
    browser: Any, site: Path, server: str
) -> None:
    wide = []
    for page in pages(site):
        for width in WIDTHS:
            browser.open(f"{server}/{page.relative_to(site).as_posix()}", width, 900)
            if browser.run("return document.documentElement.scrollWidth") > width:
                wide.append((page.name, width))
    assert browser.complaints == []
    assert wide == []


def test_search_finds_a_metric(browser: Any, server: str) -> None:
    browser.open(f"{server}/search.html?q=delay+contacts+discomfort", 1440, 900)
    found = browser.run(
        """
        const wait = (ms) => new Promise((done) => setTimeout(done, ms));
        const links = () => [...document.querySelectorAll("#search-results li a")];
        for (let i = 0; i < 500 && links().length < 3; i++) await wait(20);
        return links().map((link) => link.getAttribute("href"));
        """
    )
    assert any(link.startswith("metrics.html") for link in found[:5]), found
    assert browser.complaints == []


def test_every_metric_is_in_the_glossary() -> None:
    text = (DOCS / "metrics.md").read_text(encoding="utf-8")
    env = gymnasium.make("hazbot_gym/Inspection-v1", max_episode_steps=3)
    episode, _ = run_episode(env, make_policy("constant:0.5"), seed=0)
    names = {name for name in measure(episode) if not name.startswith("reward_")}
    assert names - set(re.findall(r"`(\w+)`", text)) == set()
