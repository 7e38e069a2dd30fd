"""Files that results depend on: of environments, of policies, and of what these import and open."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
import yaml

from hazbot_gym.evaluation import inputs
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies import Permissions
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.study.config import StudyConfig, load_study
from hazbot_gym.study.stamps import Stamps
from hazbot_gym.task.observation import LAYOUTS
from tests.refusals import refused

BLANK = inputs.Blank(LAYOUTS["tracks"], (2,))

PLACE: dict[str, Any] = {
    "name": "lab",
    "walls": [[-2, 1.2, 14, 1.2], [-2, -1.2, 14, -1.2]],
    "path": {"points": [[0, 0], [12, 0]], "corner_radius_m": 1.0},
}
POLICY = """
import numpy as np
from robot_parts_under_test import middle
SPEED = float(open({weights!r}).read())
SPEED += 0 * float(open({both!r}, "r+").read())
open({log!r}, "w").close()
class Mine:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        import lazy_helper_under_test
        return np.full((*np.shape(observation)[:-1], 1), SPEED, np.float32), state
"""


def written(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def policy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The files of a policy of one's own: its module, what that imports, and what it opens."""
    monkeypatch.syspath_prepend(tmp_path)
    package = tmp_path / "robot_parts_under_test"
    weights = written(tmp_path / "weights.txt", "0.5")
    both = written(tmp_path / "both_ways.txt", "1")
    names = {"weights": weights, "both": both, "log": tmp_path / "log.txt"}
    text = POLICY.format(**{name: str(path) for name, path in names.items()})
    return [
        both,
        written(tmp_path / "lazy_helper_under_test.py", ""),
        written(tmp_path / "policy_under_test.py", text),
        written(package / "__init__.py", ""),
        written(package / "deep.py", ""),
        written(package / "middle.py", "from . import deep\n"),
        weights,
    ]


def test_a_policy_depends_on_all_that_it_imports_and_opens(policy: list[Path]) -> None:
    allowed = Permissions(allow_code=True)
    assert inputs.of_policy("policy_under_test:Mine", [BLANK], allowed) == policy
    with refused("--allow-code"):
        inputs.of_policy("policy_under_test:Mine", [BLANK])


def test_policies_of_the_library_depend_on_their_weights_alone(tmp_path: Path) -> None:
    assert inputs.of_policy("ttc:horizon_s=2", [BLANK]) == []
    assert inputs.of_policy("ppo", [BLANK]) == []
    weights = Path(shutil.copy(SHIPPED / "ppo_tracks.npz", tmp_path))
    assert inputs.of_policy(f"learned:path={weights}", [BLANK]) == [weights]


def circle(name: str, **overrides: Any) -> ScenarioSet:
    return ScenarioSet(name=name, env="hazbot_gym/Corridor-v1", overrides=overrides)


@pytest.fixture
def study(tmp_path: Path) -> StudyConfig:
    """A study with a set for every kind of file."""
    place = written(tmp_path / "lab.yaml", yaml.safe_dump(PLACE))
    config = written(tmp_path / "config.yaml", "people: {count: [1, 1]}")
    walk = "frame,id,x,y\n" + "".join(f"{i},1,{0.5 * i},0\n" for i in range(20))
    tracks = written(tmp_path / "tracks" / "walk.csv", walk)
    written(tmp_path / "tracks" / "walk.json", json.dumps({"fps": 2}))
    replayed = {"tracks": str(tracks), "people": {"model": "replay"}}
    sets = [
        circle("plain"),
        circle("place", place=str(place)),
        circle("config", config=str(config)),
        ScenarioSet(name="tracks", env="hazbot_gym/Replay-v1", overrides=replayed),
    ]
    return load_study(sets=sets, policies=["constant:1.0"])


@pytest.mark.parametrize(
    ("file", "old", "new", "concerned"),
    [
        ("lab.yaml", "14", "15", "place"),
        ("config.yaml", "[1, 1]", "[2, 2]", "config"),
        ("tracks/walk.csv", "9.5", "9.6", "tracks"),
        ("tracks/walk.json", "2", "2.5", "tracks"),
    ],
)
def test_an_edited_file_changes_the_stamps_of_its_set_alone(
    study: StudyConfig, tmp_path: Path, file: str, old: str, new: str, concerned: str
) -> None:
    def stamps() -> dict[str, str]:
        made = Stamps(study)
        return {each.name: made.of({}, each, "constant:1.0") for each in study.sets}

    before = stamps()
    assert stamps() == before
    text = (tmp_path / file).read_text()
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new))
    after = stamps()
    assert {name for name in before if before[name] != after[name]} == {concerned}


def test_every_value_of_a_block_is_in_its_stamp() -> None:
    sets = [circle("one"), circle("two")]
    stamps = Stamps(load_study(sets=sets, policies=["ttc"]))
    found = [stamps.of({"seed": seed}, each, "ttc") for seed in (0, 1) for each in sets]
    assert len({*found, stamps.of({"seed": 0}, sets[0])}) == 5


def test_folders_may_be_moved_but_not_their_files_edited(tmp_path: Path) -> None:
    one = written(tmp_path / "a" / "place.yaml", "x")
    other = written(tmp_path / "b" / "place.yaml", "x")
    assert inputs.mark([one]) == inputs.mark([other])
    marks = {inputs.mark([one]), inputs.mark([written(other, "y")]), inputs.mark([])}
    assert len(marks) == 3


def test_two_files_of_one_name_do_not_change_places_unnoticed(tmp_path: Path) -> None:
    left = written(tmp_path / "left" / "w.txt", "1")
    right = written(tmp_path / "right" / "w.txt", "2")
    before, kept = inputs.mark([left, right]), inputs.digests([left, right])
    written(left, "2")
    written(right, "1")
    assert inputs.mark([left, right]) != before
    assert inputs.changed(kept, inputs.digests([left, right])) == str(left)


def test_what_changed_is_named() -> None:
    assert inputs.changed({"a": "1", "b": "2"}, {"a": "1", "b": "2"}) is None
    assert inputs.changed({"a": "1", "b": "2"}, {"a": "1", "b": "3"}) == "b"
    assert inputs.changed({"a": "1"}, {"a": "1", "b": "3"}) == "b"
    assert inputs.changed({"a": "1", "b": "3"}, {"a": "1"}) == "b"
