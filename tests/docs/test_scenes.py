"""The scenes of the front page in a browser, from disk: bits of the engine, and a reader's hand."""

from __future__ import annotations

import base64
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from llvmlite import binding

from hazbot_gym import make_policy
from hazbot_gym.core.jit import is_plain
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.evaluation.driver import driver_of
from hazbot_gym.evaluation.rollout import resolve
from hazbot_gym.export.wasm import OLDEST_LLVM
from hazbot_gym.live.run import Lead, PolicyDriver, Run

pytest.importorskip("sphinx", reason="needs the extra docs")
from scenes import FILE, SCENES, build, runs_of  # type: ignore[import-not-found]  # docs/_ext

pytestmark = pytest.mark.skipif(
    is_plain() or binding.llvm_version_info < OLDEST_LLVM,
    reason="needs compiled kernels of LLVM 20",
)

ROOT = Path(__file__).parents[2]
DECISIONS = 600
ARRAYS = ("robot", "people", "observation", "reward")
HELPERS = """
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const until = async (is) => {
  for (let k = 0; k < 2400 && !is(); k += 1) await wait(25);
  if (!is()) throw new Error(`never: ${is}`);
};
const pictures = async (count) => {
  for (let k = 0; k < count; k += 1) await new Promise(requestAnimationFrame);
};
const $ = (id) => document.getElementById(id);
await until(() => window.hazbot);
hazbot.setPlaying(false);
const bytes = (array) => {
  const { at, size, count } = hazbot.scene.at[array];
  return btoa(String.fromCharCode(...new Uint8Array(hazbot.robot.memory.buffer, at, size * count)));
};
"""


@pytest.fixture(scope="module")
def text() -> str:
    """Return the page: of the site in $HAZBOT_SITE, or built now."""
    if site := os.environ.get("HAZBOT_SITE"):
        return (ROOT / site / FILE).read_text(encoding="utf-8")
    return build().page


@pytest.fixture
def page(browser: Any, text: str, tmp_path: Path) -> Any:
    file = tmp_path / "scenes.html"
    file.write_text(text, encoding="utf-8")
    browser.open(file, 900, 480)
    return browser


def run(page: Any, script: str, **values: object) -> Any:
    given = "".join(f"const {name} = {json.dumps(value)};" for name, value in values.items())
    return page.run(HELPERS + given + script)


@pytest.mark.parametrize("name", SCENES)
def test_steps_have_the_bits_of_the_engine(page: Any, name: str) -> None:
    actions = np.random.default_rng(5).uniform(-0.6, 1.0, DECISIONS)
    rows = run(
        page,
        """
        await hazbot.choose(name);
        hazbot.begin(1);
        const rows = [arrays.map(bytes)];
        for (const action of actions) {
          if (hazbot.robot.outcome !== "running") break;
          hazbot.robot.step(action);
          rows.push(arrays.map(bytes));
        }
        return rows;
        """,
        name=name, arrays=ARRAYS, actions=actions.tolist(),
    )  # fmt: skip
    settings = SCENES[name]
    key = runs_of(settings)[1].info["scenario_key"]
    env = CorridorVectorEnv(1, resolve(settings.scenarios())[0], threads=1)
    observation, _ = env.reset(seed=0, options={"key": key})
    rewards = np.zeros(1)
    wrong = []
    for decision, row in enumerate(rows):
        state = env.state()
        expected = state.robots, state.people, observation, rewards
        found = [base64.b64decode(part) for part in row]
        wrong += [
            (decision, which)
            for which, one, other in zip(ARRAYS, found, expected, strict=True)
            if one != other.tobytes()
        ]
        if decision < len(actions):
            observation, rewards, *_ = env.step(actions[decision : decision + 1, None])
    assert len(rows) > 100
    assert wrong[:5] == []


@pytest.mark.parametrize(
    ("name", "policy"),
    [
        ("The paper's crossing", "fuzzy_expert"),
        ("A doorway", "ppo"),
        ("A doorway", "fuzzy_expert"),
        ("A doorway", "constant:0.5"),
        ("An inspection", "undo_lag:people=fuzzy_expert"),
        ("An inspection", "ppo"),
    ],
)
def test_a_policy_takes_the_actions_that_it_takes_in_python(
    page: Any, name: str, policy: str
) -> None:
    actions, end = run(
        page,
        """
        await hazbot.choose(name);
        $("policy").value = policy;
        const actions = [];
        while (hazbot.robot.outcome === "running") {
          actions.push(hazbot.robot.action(hazbot.policy("policy")));
          hazbot.robot.step(actions[actions.length - 1]);
        }
        return [actions, hazbot.robot.outcome];
        """,
        name=name, policy=policy,
    )  # fmt: skip
    settings = SCENES[name]
    config, _ = resolve(settings.scenarios())
    env = CorridorVectorEnv(1, config, threads=1)
    key = runs_of(settings)[0].info["scenario_key"]
    observation, info = env.reset(seed=0, options={"key": key})
    driver = driver_of(make_policy(policy), config, policy)
    state, starts, ended, expected = None, np.array([True]), np.array([False]), []
    while not ended[0]:
        action, state = driver.predict(observation, state, starts)
        expected.append(float(action[0, 0]))
        observation, _, terminated, truncated, info = env.step(action)
        ended, starts = terminated | truncated, np.array([False])
    assert end == info["outcome"][0]
    assert actions == expected


def test_a_person_who_is_led_walks_as_on_the_page_with_a_server(page: Any) -> None:
    """The server's page runs on pymunk, so that bits are not compared."""
    settings = SCENES["A doorway"].model_copy(update={"policy": "constant:0"})
    driven = Run(settings, PolicyDriver(make_policy("constant:0")))
    for _ in range(30):
        driven.step()
    person = int(driven.now.persons[0])
    x, y = (float(driven.now.people[0][axis]) for axis in "xy")
    for decision in range(60):
        driven.step([Lead(person=person, x_m=x + 0.5, y_m=y + 0.2)] if decision < 20 else [])
    found = run(
        page,
        """
        await hazbot.choose("A doorway");
        const step = (count) => { for (let k = 0; k < count; k += 1) hazbot.robot.step(-1); };
        step(30);
        hazbot.robot.lead(person, x, y);
        step(20);
        hazbot.robot.letGo(person);
        step(40);
        return hazbot.robot.people().map(({ index, x, y }) => [index, x, y]);
        """,
        person=person, x=x + 0.5, y=y + 0.2,
    )  # fmt: skip
    expected = [
        [int(index), float(each["x"]), float(each["y"])]
        for index, each in zip(driven.now.persons, driven.now.people, strict=True)
    ]
    assert np.allclose(found, expected, atol=1e-6)


def test_a_reader_drags_a_person(page: Any) -> None:
    index, x, y = run(
        page,
        """
        await hazbot.choose("A doorway");
        for (let k = 0; k < 30; k += 1) hazbot.step();
        await pictures(2);
        const inside = ({ x, y }) => Math.abs(y) < 0.8 && x > 2 && x < 10;
        const { index } = hazbot.frame.people.find(inside);
        return [index, ...hazbot.pixels(index)];
        """,
    )
    mouse = page.page.mouse
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + 10, y + 30, steps=4)
    led, away = run(
        page,
        """
        const { x, y } = hazbot.frame.people.find((person) => person.index === index);
        for (let k = 0; k < 20; k += 1) hazbot.step();
        const person = hazbot.frame.people.find((each) => each.index === index);
        return [person.is_led, hazbot.view.scale * Math.hypot(person.x - x, person.y - y)];
        """,
        index=index,
    )
    mouse.up()
    assert led
    assert abs(away - np.hypot(10, 30)) < 6
    assert run(page, "return [hazbot.robot.led.size, hazbot.ghost.led.size];") == [0, 0]
    assert page.complaints == []


def test_an_arrow_key_takes_over_and_drives(page: Any) -> None:
    driver, speed = run(
        page,
        """
        const press = (type) =>
          document.body.dispatchEvent(new KeyboardEvent(type, { key: "ArrowUp", bubbles: true }));
        press("keydown");
        await until(() => hazbot.frame.speed > 0.4);
        press("keyup");
        return [$("policy").value, hazbot.frame.speed];
        """,
    )
    assert (driver, speed > 0.4) == ("you", True)
    assert page.complaints == []


def test_scenes_play_by_themselves_and_a_browser_without_webassembly_says_so(
    page: Any, text: str, browser: Any, tmp_path: Path
) -> None:
    run(page, "hazbot.setPlaying(true); await until(() => hazbot.frame.decision > 20);")
    assert page.complaints == []
    file = tmp_path / "without.html"
    file.write_text(text.replace('"use strict";', "WebAssembly = undefined;", 1))
    browser.open(file, 900, 480)
    told = browser.run(
        """
        for (let k = 0; k < 400 && !document.getElementById("sorry").textContent; k += 1)
          await new Promise((done) => setTimeout(done, 25));
        return document.getElementById("sorry").textContent;
        """
    )
    assert "cannot run the scenes" in told
    assert len(text) < 800_000
