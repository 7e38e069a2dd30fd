from __future__ import annotations

from pathlib import Path

import pytest

from hazbot_gym.evaluation.scenario_set import DEFAULT_SETS, ScenarioSet, parse_overrides
from hazbot_gym.study.config import load_study
from tests.refusals import refused

PLAYED = {"name": "real people, replay", "env": "hazbot_gym/Circle-v1"}
FRONTS = {"sets": ["E*"], "families": ["ttc"], "groups": {"ttc": ["ppo"]}}


def test_a_file_holds_deltas_and_changes_go_before_it(tmp_path: Path) -> None:
    file = tmp_path / "study.yaml"
    file.write_text("episodes: 7\nseed: 3\nsets: [E*, {name: mine, env: hazbot_gym/Circle-v1}]\n")
    study = load_study(file, seed=4, tracks=None)
    assert (study.episodes, study.seed) == (7, 4)
    assert [scenarios.name for scenarios in study.all_sets] == ["E*", "mine"]
    assert study.policies == load_study().policies


def test_tracks_add_real_people_as_recorded_and_as_reacting(tmp_path: Path) -> None:
    study = load_study(tracks=tmp_path)
    added = study.all_sets[len(DEFAULT_SETS) :]
    assert [scenarios.overrides["people"] for scenarios in added] == [
        {"model": "replay"},
        {"model": "seeded"},
    ]
    assert {scenarios.overrides["tracks"] for scenarios in added} == {str(tmp_path)}


def test_drives_among_real_people_have_a_limit_of_their_own(tmp_path: Path) -> None:
    study = load_study(tracks=tmp_path, episodes=100, track_episodes=30)
    counts = [study.episodes_in(each) for each in study.all_sets[-3:]]
    assert counts == [100, 30, 30]


def test_equal_values_are_the_same_study_and_every_change_makes_another(tmp_path: Path) -> None:
    changes = [
        {"episodes": 3},
        {"seed": 1},
        {"tracks": tmp_path},
        {"ssm": {"braking_mps2": 0.5}},
        {"engine": "pymunk"},
        {"policies": ["constant:1.0"]},
        {"sets": [ScenarioSet(name="E*", env="hazbot_gym/Circle-v1")]},
    ]
    identities = [load_study(**change).identity() for change in changes]
    assert len({load_study().identity(), *identities}) == len(changes) + 1
    assert load_study(seed=0).identity() == load_study().identity()


@pytest.mark.parametrize(
    ("change", "field", "allowed"),
    [
        ({"episodes": 0}, "episodes ... 0", "1"),
        ({"episodez": 5}, "episodez", "episodes_per_shard"),
        ({"sets": ["E9"]}, "sets ... 'E9'", "E5.5"),
        ({"policies": []}, "policies", "at least 1"),
        ({"policies": ["constant", "constant"]}, "policies ... 'constant' twice", "once"),
        ({"reference": "constant:0.1"}, "reference ... 'constant:0.1'", "constant:0.25"),
        ({"ssm": {"braking_mps2": 0}}, "ssm.braking_mps2 ... 0", "greater than 0"),
        ({"ssm": {"brakes": 1}}, "ssm.brakes", "unknown"),
        ({"sets": [{"name": "x"}]}, "sets.0.env", "required"),
        ({"tracks": "/no/such/folder"}, "tracks ... '/no/such/folder'", "not exist"),
        ({"engine": "steam"}, "engine ... 'steam'", "'batched' or 'pymunk'"),
        ({"episodes": True}, "episodes ... True", "integer"),
        ({"episodes": "5"}, "episodes ... '5'", "integer"),
        ({"episodes": 5.0}, "episodes ... 5.0", "integer"),
        ({"episodes": 10**12}, "episodes ... 1000000000000", "1000000"),
        ({"resamples": 10**12}, "resamples ... 1000000000000", "less"),
        ({"trials": 10**12}, "trials ... 1000000000000", "less"),
        ({"trial_episodes": 10**12}, "trial_episodes ... 1000000000000", "less than or equal"),
        ({"episodes_per_shard": 10**12}, "episodes_per_shard: given", "less"),
        ({"seed": 2**64}, "seed ... 18446744073709551616", "184"),
        ({"oracle": {"sets": ["E*"], "worlds": 10**9}}, "oracle.worlds: given", "10000"),
        ({"ssm": {"braking_mps2": "1"}}, "ssm.braking_mps2 ... '1'", "number"),
        ({"ssm": {"reaction_s": 1e300}}, "ssm.reaction_s ... 1e+300", "sizes of"),
        ({"learners": [{"name": "a", "config": "a", "seeds": 10**6}]}, "seeds: given", "1000"),
        ({"trial_overrides": {"tear": "sonar"}}, "tear", "tier"),
        ({"policies": [1]}, "policies.0 ... 1", "string"),
        (
            {"sets": [{"name": "x", "env": "Circle-v1", "overrides": None}]},
            "sets.0.overrides",
            "dict",
        ),
        ({"confidence": 1.0}, "confidence ... 1.0", "less than 1"),
        ({"tracks": ".", "sets": [PLAYED]}, "sets ... 'real people, replay'", "tracks"),
        ({"fronts": FRONTS}, "fronts.groups ... 'ttc'", "fronts.families"),
    ],
)
def test_bad_values_are_one_line_with_field_and_what_is_allowed(
    change: dict[str, object], field: str, allowed: str
) -> None:
    with refused(f"{field} ... {allowed}"):
        load_study(**change)


@pytest.mark.parametrize(
    "names",
    [("a b", "a_b"), ("PPO", "ppo"), ("a:b", "a/b"), ("\u00c5", "\u212b"), ("x", "x"), ("ß", "SS")],
)
def test_learners_that_would_share_a_folder_are_refused(names: tuple[str, str]) -> None:
    learners = [{"name": name, "config": "run.yaml"} for name in names]
    with refused("share a folder") as raised:
        load_study(learners=learners)
    assert all(repr(name) in str(raised.value) for name in names)


@pytest.mark.parametrize("name", ["..", ".", "", "a.", ".hidden", "../up", "x" * 201, "я" * 101])
def test_the_name_of_a_learner_must_be_that_of_a_folder(name: str) -> None:
    with refused("learners.0.name"):
        load_study(learners=[{"name": name, "config": "run.yaml"}])


@pytest.mark.parametrize("value", ["yes", "190:20:30:15", "2020-13-45", "'5'", "1e2x"])
def test_text_that_looks_like_a_number_is_refused_in_one_line(tmp_path: Path, value: str) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(f"episodes: {value}")

    with refused("episodes ... int"):
        load_study(file)


@pytest.mark.parametrize("field", ["sets", "ssm", "episodes", "learners", "trial_overrides"])
def test_section_left_empty_is_refused(tmp_path: Path, field: str) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(f"{field}:\n")

    with refused(f"{field} ... None"):
        load_study(file)


def test_key_given_twice_is_refused_with_its_line(tmp_path: Path) -> None:
    file = tmp_path / "study.yaml"
    file.write_text("episodes: 3\nseed: 1\nepisodes: 4\n")

    with refused("study.yaml ... line 3 ... 'episodes'"):
        load_study(file)


@pytest.mark.parametrize("text", ["episodes: [", "- a\n- b\n", "5"])
def test_a_file_that_is_no_mapping_is_one_line(tmp_path: Path, text: str) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(text)
    with refused("config"):
        load_study(file)


def test_overrides_nest_and_are_read_as_yaml() -> None:
    changes = ["tier=sonar", "people.count=[2, 4]", "people.speeds.mean_mps=1.2"]
    assert parse_overrides(changes) == {
        "tier": "sonar",
        "people": {"count": [2, 4], "speeds": {"mean_mps": 1.2}},
    }


@pytest.mark.parametrize(
    "changes",
    [
        ["tier"],
        ["=3"],
        ["people.=3"],
        ["a=1", "a.b=2"],
        ["a=["],
        ["a=1", "a=1"],
        ["a.b=1", "a={b: 2}"],
        ["a.b=1", "a={c: 2}"],
        ["a=!!int x"],
        ["a=1\0"],
        ["a={b: 1, b: 2}"],
    ],
)
def test_an_override_that_makes_no_sense_is_one_line(changes: list[str]) -> None:
    with refused("set"):
        parse_overrides(changes)


def test_a_geometry_of_the_paper_is_one_scenario_and_counts_as_one() -> None:
    """Repeated it would be the same drive again: intervals of no width, p-values of nothing."""
    study = load_study(sets=["E*", "Crossing"], episodes=25)

    assert [study.episodes_in(each) for each in study.all_sets] == [1, 25]
