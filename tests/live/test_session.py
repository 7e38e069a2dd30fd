"""A page's session: driven, swapped, dragged; and the same numbers as ``hazbot eval``."""

from __future__ import annotations

import math
from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.evaluation.metrics import measure
from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.live import messages
from hazbot_gym.live.policies import Policies
from hazbot_gym.live.session import Session
from hazbot_gym.live.settings import YOU, Settings
from tests.refusals import refused, says

LIVE = Policies("constant:0")


def session(**settings: Any) -> Session:
    return Session(LIVE, Settings(**settings))


def finish(page: Session) -> messages.Frame:
    while not page.is_over:
        page.tick()
    return page.frame()


def drive(page: Session, decisions: int) -> None:
    for _ in range(decisions):
        page.tick()


def someone(page: Session) -> messages.Person:
    """Return the person nearest to the robot."""
    frame = page.frame()
    x, y, _ = frame.pose
    return min(frame.people, key=lambda person: math.hypot(person.x - x, person.y - y))


def where(page: Session, index: int) -> tuple[float, float]:
    (found,) = (person for person in page.frame().people if person.index == index)
    return found.x, found.y


@pytest.mark.parametrize(
    "settings",
    [
        Settings(),
        Settings(env="Doorway-v1", episode=2, policy="idm", width_m=2.0, people=4, unyielding=0.5),
        Settings(env="Inspection-v1", seed=3, tier="sonar", noise=2.0, latency=2),
        Settings(env="C*"),
    ],
)
def test_a_run_is_measured_as_by_hazbot_eval_to_the_last_bit(settings: Settings) -> None:
    page = Session(LIVE, settings)
    finish(page)
    rows = evaluate(
        settings.policy,
        settings.scenarios().env,
        episodes=settings.episode + 1,
        seed=settings.seed,
        overrides=settings.overrides(),
        engine="pymunk",
    )
    for name, value in measure(page.run.episode()).items():
        np.testing.assert_equal(value, rows[-1][name], err_msg=name)


def test_a_ghost_and_looking_on_do_not_change_the_run() -> None:
    alone, watched = session(), session(ghost="constant:1")
    for page in (alone, watched):
        page.receive(messages.Play(is_playing=True))
        finish(page)
    assert alone.run.actions == watched.run.actions
    assert alone.frame().totals == watched.frame().totals


def test_a_ghost_called_in_mid_run_is_as_far_as_the_robot() -> None:
    page, other = session(policy="constant:0.5"), session(policy="constant:1")
    drive(page, 20)
    drive(other, 20)
    page.receive(
        messages.Configure(settings=page.settings.model_copy(update={"ghost": "constant:1"}))
    )
    ghost = page.frame().ghost
    assert ghost is not None
    assert ghost.pose == other.frame().pose != page.frame().pose


def test_a_policy_is_swapped_in_mid_run() -> None:
    page = session(policy="constant:1", people=0)
    drive(page, 20)
    sent = page.receive(
        messages.Configure(settings=page.settings.model_copy(update={"policy": "constant:0.5"}))
    )
    assert [each.kind for each in sent] == ["scene", "frame"]
    drive(page, 10)
    assert page.run.decision == 30
    assert page.run.actions == [1.0] * 20 + [0.0] * 10


def test_the_price_of_nearness_acts_at_once_on_a_policy_that_observes_it(priced: str) -> None:
    page = Session(Policies(priced), Settings(policy=priced, ghost=priced, people=0))
    drive(page, 10)
    for price in (16.0, 1.0):
        changed = page.settings.model_copy(update={"price": price})
        sent = page.receive(messages.Configure(settings=changed))
        assert [each.kind for each in sent] == ["scene", "frame"]
        drive(page, 10)
    assert page.run.actions == [0.0] * 10 + [-1.0] * 10 + [1.0] * 10
    frame = page.frame()
    assert frame.ghost is not None
    assert frame.ghost.pose[0] > frame.pose[0]  # at the last price from the start on
    path = priced.partition(":")[2]
    assert f"--policy learned:price=1.0,{path} " in page.scene().command


def test_other_policies_know_no_price(priced: str) -> None:
    policies = Policies(priced, f"learned:price=2,path={priced.partition(':')[2]}")
    offered = {each.name: each.prices for each in policies.choices() if each.prices}
    assert offered == dict.fromkeys((priced, "ppo_prices"), (1.0, 16.0, 4.0))
    page = session(policy="constant:1")
    driver = page.run.driver
    page.receive(messages.Configure(settings=page.settings.model_copy(update={"price": 2.0})))
    assert page.run.driver is driver
    assert "price" not in page.scene().command


def test_a_price_beyond_those_of_the_policy_is_refused(priced: str) -> None:
    page = Session(Policies(priced), Settings(policy=priced))
    changed = page.settings.model_copy(update={"price": 17.0})
    (line,) = page.receive(messages.Configure(settings=changed))
    assert isinstance(line, messages.Line)
    says(line.text, "price ... 17 ... 1 to 16")
    assert page.settings.price is None
    with refused("price ... 0"):
        messages.parse('{"kind": "configure", "settings": {"price": 0}}')


def test_other_settings_start_anew() -> None:
    page = session()
    drive(page, 20)
    page.receive(messages.Configure(settings=page.settings.model_copy(update={"people": 1})))
    assert page.run.decision == 0
    assert len(page.run.env.world.people) == 1


def test_a_person_at_the_page_drives() -> None:
    page = session(policy=YOU, people=0)
    drive(page, 5)
    assert page.frame().command == 0.0
    page.receive(messages.Throttle(share=0.5))
    drive(page, 15)
    assert page.frame().command == 0.25
    assert page.frame().speed == pytest.approx(0.25, abs=0.05)


def test_a_person_who_is_held_walks_to_the_pointer_and_goes_on_when_let_go() -> None:
    page = session(policy="constant:0", people=3)
    drive(page, 10)
    person = someone(page)
    target = (person.x, 0.9 if person.y < 0 else -0.9)
    page.receive(messages.Hold(person=person.index, x_m=target[0], y_m=target[1]))
    drive(page, 15)
    assert where(page, person.index) == pytest.approx(target, abs=1e-3)
    assert [each.is_led for each in page.frame().people if each.index == person.index] == [True]
    page.receive(messages.LetGo(person=person.index))
    drive(page, 15)
    assert math.dist(where(page, person.index), target) > 0.5
    assert page.frame().is_edited


def test_a_scripted_person_who_is_let_go_walks_straight_on() -> None:
    page = session(env="E*", policy="constant:0")
    drive(page, 5)
    page.receive(messages.Hold(person=0, x_m=3.0, y_m=1.5))
    drive(page, 15)
    assert where(page, 0) == (3.0, 1.5)
    page.receive(messages.LetGo(person=0))
    drive(page, 10)
    assert where(page, 0) == pytest.approx((2.5, 1.5), abs=1e-6)  # at 0.5 m/s towards the robot


def test_a_person_cannot_be_led_through_a_wall() -> None:
    page = session(policy="constant:0", people=3)
    drive(page, 10)
    person = someone(page)
    page.receive(messages.Hold(person=person.index, x_m=2.0, y_m=0.9))
    drive(page, 60)
    assert where(page, person.index) == (2.0, 0.9)
    page.receive(messages.Hold(person=person.index, x_m=2.0, y_m=5.0))
    drive(page, 20)
    assert where(page, person.index)[1] <= 1.0


def test_a_person_led_against_the_robot_ends_the_run() -> None:
    page = session(policy="constant:0", people=3)
    drive(page, 10)
    page.receive(messages.Hold(person=someone(page).index, x_m=0.0, y_m=0.0))
    drive(page, 100)
    frame = page.frame()
    assert (frame.outcome, frame.caused_by) == ("contact_person", "person")


def test_people_are_added_and_removed() -> None:
    page = session(policy="constant:0", people=1)
    page.receive(messages.AddPerson(x_m=5.0, y_m=0.6))
    page.receive(messages.AddPerson(x_m=8.0, y_m=-0.6))
    drive(page, 1)
    people = {person.index for person in page.frame().people}
    assert {1, 2} <= people
    drive(page, 10)
    assert where(page, 1)[0] < 5.0  # it comes towards the robot
    page.receive(messages.RemovePerson(person=1))
    drive(page, 1)
    assert {person.index for person in page.frame().people} == people - {1}
    assert page.frame().is_edited


def test_the_tracker_sees_an_added_person() -> None:
    page = session(policy="constant:0", people=0)
    page.receive(messages.AddPerson(x_m=3.0, y_m=0.6))
    drive(page, 2)
    names = [field.name for field in page.scene().fields]
    seen = dict(zip(names, page.frame().observation, strict=True))
    assert seen["person0_present"] == 1.0
    assert seen["person0_distance_m"] == pytest.approx(2.9, abs=0.3)


def test_there_is_no_room_on_the_robot_or_behind_a_wall() -> None:
    page = session(policy="constant:0", people=0)
    for x_m, y_m in ((0.2, 0.0), (2.0, 3.0)):
        (line,) = page.receive(messages.AddPerson(x_m=x_m, y_m=y_m))
        assert isinstance(line, messages.Line)
        says(line.text, "add: ... no room")


def test_a_recorded_run_is_the_same_run_with_its_edits() -> None:
    page = session(policy="fuzzy_expert", people=3)
    drive(page, 10)
    person = someone(page)
    page.receive(messages.Hold(person=person.index, x_m=person.x, y_m=0.0))
    page.receive(messages.AddPerson(x_m=9.0, y_m=0.5))
    drive(page, 10)
    page.receive(messages.LetGo(person=person.index))
    drive(page, 20)
    (file,) = page.receive(messages.Export(what="run"))
    assert isinstance(file, messages.Download)

    again = session()
    again.receive(messages.Load(text=file.text))
    drive(again, 40)
    assert again.run.actions == page.run.actions
    np.testing.assert_array_equal(
        [state.x for state in again.run.snapshots], [state.x for state in page.run.snapshots]
    )
    for mine, other in zip(again.run.snapshots, page.run.snapshots, strict=True):
        assert mine.people.tobytes() == other.people.tobytes()


@pytest.mark.parametrize(
    "settings", [Settings(env="Doorway-v1", width_m=2.0, people=4), Settings(env="C*", latency=1)]
)
def test_the_scene_is_a_config_of_the_environment(settings: Settings) -> None:
    page = Session(LIVE, settings)
    (file,) = page.receive(messages.Export(what="scene"))
    assert isinstance(file, messages.Download)
    from hazbot_gym.utils.yaml_loader import parse_yaml

    env = gymnasium.make("hazbot_gym/Corridor-v1", config=parse_yaml(file.text, "scene"))
    assert env.unwrapped.config == page.run.env.config  # type: ignore[attr-defined]


def test_a_person_is_scored_beside_the_expert_and_the_learned_policy() -> None:
    page = session(policy=YOU, people=0, env="InspectionEmpty-v1")
    page.receive(messages.Throttle(share=1.0))
    finish(page)
    (scores,) = page.receive(messages.Compare())
    assert isinstance(scores, messages.Scores)
    mine = scores.returns[YOU]
    assert mine[0] == page.frame().results["return"]  # type: ignore[index]
    assert mine[1:] == (None,) * 9
    assert {len(each) for each in scores.returns.values()} == {10}
    assert None not in scores.returns["fuzzy_expert"]


def test_a_run_that_was_helped_has_no_score() -> None:
    page = session(policy=YOU, people=0)
    page.receive(messages.Throttle(share=1.0))
    page.receive(messages.AddPerson(x_m=11.0, y_m=1.0))
    finish(page)
    assert page.receive(messages.Compare())[0].returns[YOU] == (None,) * 10  # type: ignore[union-attr]


def test_the_next_scenario_has_another_key() -> None:
    page = session()
    key = page.scene().key
    page.receive(messages.Restart(by=1))
    assert (page.settings.episode, page.run.decision) == (1, 0)
    assert page.scene().key != key
    page.receive(messages.Restart(by=-1))
    assert page.scene().key == key


def test_policies_that_are_not_on_offer_are_refused_and_the_run_goes_on() -> None:
    page = session()
    drive(page, 5)
    for spec in ("learned:path=/etc/passwd", "os:getcwd", "shielded:policy=ppo", "nothing"):
        changed = page.settings.model_copy(update={"policy": spec})
        (line,) = page.receive(messages.Configure(settings=changed))
        assert isinstance(line, messages.Line)
        says(line.text, f"policy: given {spec!r} ... does not offer")
    drive(page, 5)
    assert page.run.decision == 10


def test_a_circle_has_no_width_and_says_so() -> None:
    page = session(env="Circle-v1")
    changed = page.settings.model_copy(update={"width_m": 2.0})
    (line,) = page.receive(messages.Configure(settings=changed))
    assert isinstance(line, messages.Line)
    says(line.text, "place_options: given 'width_m'")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "JSON"),
        ('{"kind": "run_code"}', "message: given ... run_code"),
        ('{"kind": "throttle", "share": 2}', "share: given 2"),
        ('{"kind": "hold", "person": -1, "x_m": 0, "y_m": 0}', "person: given -1"),
        ('{"kind": "configure", "settings": {"env": "Replay-v1"}}', "env: given 'Replay-v1'"),
        ('{"kind": "configure", "settings": {"place": "/etc/passwd"}}', "place"),
    ],
)
def test_messages_that_are_none_are_refused(text: str, said: str) -> None:
    with refused(said):
        messages.parse(text)


def test_a_file_that_is_no_run_is_refused() -> None:
    (line,) = session().receive(messages.Load(text='{"actions": [3]}'))
    assert isinstance(line, messages.Line)
    says(line.text, "run: ")


@pytest.mark.parametrize("env", ["Corridor-v1", "Inspection-v1", "Circle-v1", "Aisle-v1"])
def test_frames_are_json_of_finite_numbers(env: str) -> None:
    page = session(env=env, ghost="constant:1")
    for _ in range(30):
        for sent in page.tick():
            assert "NaN" not in sent.model_dump_json()
    assert (page.scene().plume is None) == (page.scene().leak == ())
