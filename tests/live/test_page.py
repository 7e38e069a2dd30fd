"""The page in a real browser: driven, people dragged, policies swapped, links followed."""

from __future__ import annotations

from typing import Any

import pytest

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
const choose = (id, value) => { $(id).value = value; $(id).dispatchEvent(new Event("change")); };
const press = (key, type = "keydown", more = {}) => {
  const event = new KeyboardEvent(type, { key, bubbles: true, cancelable: true, ...more });
  document.body.dispatchEvent(event);
};
const steps = async (count) => {
  for (let k = 0; k < count; k += 1) {
    const before = hazbot.frame.decision;
    press(".");
    await until(() => hazbot.frame.decision > before || hazbot.frame.results);
  }
};
await until(() => window.hazbot && hazbot.frame && hazbot.scene);
"""


def run(browser: Any, script: str) -> Any:
    return browser.run(HELPERS + script)


def still(browser: Any, address: str, link: str = "", size: tuple[int, int] = (1280, 900)) -> None:
    """Open a page that waits: with reduced motion nothing plays by itself."""
    browser.page.emulate_media(reduced_motion="reduce")
    browser.open(address + link, *size)


def test_an_arrow_key_takes_over_and_drives(browser: Any, address: str) -> None:
    browser.open(f"{address}?policy=constant%3A0&people=0", 1280, 900)
    driver, speed, fps, size = run(
        browser,
        """
        press("ArrowUp");
        await until(() => hazbot.scene.settings.policy === "you" && hazbot.frame.speed > 0.3);
        press("ArrowUp", "keyup");
        await until(() => document.documentElement.dataset.fps);
        const { fps, bytes } = document.documentElement.dataset;
        return [$("policy").value, hazbot.frame.speed, Number(fps), Number(bytes)];
    """,
    )
    print(f"{fps} pictures and {size} bytes a second")
    assert (driver, speed > 0.3) == ("you", True)
    assert fps > 0
    assert 0 < size < 100_000
    assert browser.complaints == []


def test_a_person_is_dragged_with_the_pointer(browser: Any, address: str) -> None:
    still(browser, address, "?policy=constant%3A0&people=3")
    x, y, index = run(
        browser,
        """
        await steps(10);
        const inside = (person) => Math.abs(person.y) < 1 && person.x < 12;
        const { index } = hazbot.frame.people.find(inside);
        await pictures(2);
        return [...hazbot.pixels(index), index];
    """,
    )
    mouse = browser.page.mouse
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + 10, y + 30, steps=4)
    led = run(
        browser,
        f"""
        await steps(6);
        const person = hazbot.frame.people.find((each) => each.index === {index});
        const [px, py] = hazbot.pixels({index});
        return [person.is_led, hazbot.frame.is_edited, px, py];
    """,
    )
    mouse.up()
    free = run(
        browser,
        f"""
        await steps(2);
        return hazbot.frame.people.find((each) => each.index === {index}).is_led;
    """,
    )
    assert led[:2] == [True, True]
    assert led[2:] == pytest.approx([x + 10, y + 30], abs=12)
    assert free is False
    assert browser.complaints == []


def test_people_are_led_added_and_removed_by_keys(browser: Any, address: str) -> None:
    still(browser, address, "?policy=constant%3A0&people=0")
    counts, moved = run(
        browser,
        """
        const count = () => hazbot.frame.people.length;
        const counts = [count()];
        press("a");
        await until(() => count() === 1);
        counts.push(count());
        press("p");
        const before = hazbot.frame.people[0].y;
        press("ArrowUp", "keydown", { shiftKey: true });
        await pictures(25);
        press("ArrowUp", "keyup", { shiftKey: true });
        await steps(4);
        const moved = hazbot.frame.people[0].y - before;
        press("Enter");
        press("Delete");
        await until(() => count() === 0);
        return [[...counts, count()], moved];
    """,
    )
    assert counts == [0, 1, 0]
    assert moved > 0.1
    assert browser.complaints == []


def test_a_key_chooses_a_person_who_is_not_drawn_yet(browser: Any, address: str) -> None:
    still(browser, address, "?policy=constant%3A0&people=0")
    assert run(
        browser,
        """
        window.requestAnimationFrame = () => 0;  // no pictures any more
        press("p");
        const seen = [$("line").textContent];
        press("a");
        await until(() => hazbot.frame.people.length === 1);
        press("p");
        press("Delete");
        await until(() => hazbot.frame.people.length === 0);
        return seen;
    """,
    ) == ["There is nobody to choose"]
    assert browser.complaints == []


def test_the_price_of_nearness_is_a_slider_for_a_policy_that_observes_it(
    browser: Any, address: str, priced: str
) -> None:
    still(browser, address)
    assert run(
        browser,
        f"""
        await steps(3);
        const seen = [$("price").disabled];
        choose("policy", {priced!r});
        await until(() => !$("price").disabled);
        seen.push($("price").min, $("price").max, $("price").value);
        choose("price", "10");
        await until(() => hazbot.scene.settings.price === 10);
        seen.push(document.querySelector("output[for=price]").textContent);
        return [...seen, hazbot.frame.decision, location.search.includes("price=10")];
    """,
    ) == [True, "1", "16", "4", "10 s/s", 3, True]
    assert browser.complaints == []


def test_a_policy_is_swapped_in_mid_run_and_a_ghost_joins(browser: Any, address: str) -> None:
    still(browser, address)
    decisions, driver, ghost = run(
        browser,
        """
        await steps(12);
        choose("policy", "idm");
        await until(() => hazbot.scene.settings.policy === "idm");
        press(" ");
        const first = hazbot.frame.decision;
        choose("ghost", "ppo");
        await until(() => hazbot.frame.ghost);
        await steps(3);
        return [[first, hazbot.frame.decision], hazbot.settings.policy, hazbot.frame.ghost];
    """,
    )
    assert decisions[0] >= 12
    assert decisions[1] >= decisions[0] + 3
    assert (driver, ghost["policy"]) == ("idm", "ppo")
    assert ghost["time_s"] == pytest.approx(decisions[1] / 10)
    assert browser.complaints == []


RUN = """
await steps(40);
const { pose, totals, people, time_s } = hazbot.frame;
return { pose, totals, people, time_s, key: hazbot.scene.key, link: location.href };
"""


def test_a_link_gives_the_same_run_again(browser: Any, address: str) -> None:
    still(browser, address)
    first = run(
        browser,
        """
        choose("env", "Doorway-v1");
        choose("people", "5");  // before the answer
        choose("policy", "velocity_obstacle");
        const isSet = ({ env, people, policy }) =>
          env === "Doorway-v1" && people === 5 && policy === "velocity_obstacle";
        await until(() => isSet(hazbot.scene.settings));
        press("n");
        await until(() => hazbot.scene.settings.episode === 1 && hazbot.frame.decision === 0);
        await steps(1);
        press("r");
        await until(() => hazbot.frame.decision === 0);
    """
        + RUN,
    )
    still(browser, first["link"])
    again = run(browser, RUN)
    assert again == first
    assert "Doorway" in again["link"]
    assert browser.complaints == []


def test_what_is_refused_is_told_and_the_page_goes_on(browser: Any, address: str) -> None:
    still(browser, address, "?policy=learned%3Apath%3D%2Fetc%2Fpasswd")
    text, decision = run(
        browser,
        """
        await until(() => $("line").textContent);
        const text = $("line").textContent;
        await steps(3);
        return [text, hazbot.frame.decision];
    """,
    )
    assert "does not offer" in text
    assert decision == 3
    assert browser.complaints == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_shows_everything_without_scrolling_sideways(
    browser: Any, address: str, scheme: str
) -> None:
    browser.page.emulate_media(color_scheme=scheme)
    still(browser, address, "?env=Inspection-v1", (390, 844))
    wide, seen, small = run(
        browser,
        """
        await steps(2);
        const heights = [...document.querySelectorAll("button, select")]
          .filter((each) => each.offsetParent).map((each) => each.getBoundingClientRect().height);
        const { scrollWidth, clientWidth } = document.documentElement;
        return [scrollWidth, clientWidth, Math.min(...heights)];
    """,
    )
    assert wide == seen <= 390
    assert small >= 40  # of a finger
    assert browser.complaints == []


def test_every_control_has_a_name(browser: Any, address: str) -> None:
    still(browser, address)
    nameless = run(
        browser,
        """
        const isNamed = (each) =>
          each.labels?.length || each.textContent.trim() || each.getAttribute("aria-label");
        return [...document.querySelectorAll("button, select, input, canvas[tabindex]")]
          .filter((each) => !isNamed(each)).map((each) => each.id);
    """,
    )
    assert nameless == []
