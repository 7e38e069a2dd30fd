from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.training.config import TrainConfig, load_training, split
from tests.refusals import refused


def test_a_file_holds_deltas_and_changes_go_before_it(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("algorithm: sac\nseed: 3\nenv: hazbot_gym/Circle-v1\n")
    config = load_training(file, seed=4, steps=None)
    assert (config.algorithm, config.seed, config.steps) == ("sac", 4, TrainConfig().steps)
    assert config.env == ("hazbot_gym/Circle-v1",)
    (environment,) = config.environments()
    assert (environment.place, environment.max_episode_steps) == ("circle", 2000)


@pytest.mark.parametrize("field", ["overrides", "options", "network", "validation", "env"])
def test_section_left_empty_is_refused(tmp_path: Path, field: str) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(f"{field}:\n")
    with refused(f"{field}: given None"):
        load_training(file)


def test_equal_values_are_the_same_run_and_every_change_makes_another() -> None:
    changes: list[dict[str, Any]] = [
        {"seed": 1},
        {"steps": 5},
        {"engine": "pymunk"},
        {"options": {"gamma": 0.9}},
        {"validation": {"episodes": 1}},
    ]
    identities = [load_training(**change).identity() for change in changes]
    assert len({load_training().identity(), *identities}) == len(changes) + 1
    assert load_training(seed=0).identity() == load_training().identity()


def test_worlds_are_shared_out_evenly() -> None:
    assert split(512, 1) == [512]
    assert split(10, 4) == [3, 3, 2, 2]


@pytest.mark.parametrize(
    ("change", "field", "allowed"),
    [
        (
            {"algorithm": "a2c"},
            "algorithm: given 'a2c'",
            "'ppo', 'sac', 'td3', 'tqc', 'crossq', 'dqn'",
        ),
        ({"algoritm": "ppo"}, "algoritm: unknown key", "algorithm, env, overrides"),
        ({"validation": {"epsiodes": 3}}, "validation.epsiodes: unknown key", "every_steps"),
        ({"steps": 0}, "steps: given 0", "greater than or equal to 1"),
        ({"seed": -1}, "seed: given -1", "greater than or equal to 0"),
        ({"seed": 2**32}, "seed: given 4294967296", "less than or equal to 4294967295"),
        ({"engine": "steam"}, "engine: given 'steam'", "'batched' or 'pymunk'"),
        ({"env": []}, "env", "at least 1"),
        (
            {"hidden": ["person64_present"]},
            "hidden: given 'person64_present'",
            "names of the obs",
        ),
        ({"hidden": ["person*_heigth"]}, "hidden: given 'person*_heigth'", "names of the obs"),
        (
            {"algorithm": "sac", "residual": {}},
            "residual: given with algorithm 'sac'",
            "'recurrent_ppo'",
        ),
        ({"worlds": 10**9}, "worlds: given 1000000000", "less than or equal to 100000"),
        ({"threads": 10**9}, "threads: given 1000000000", "less than or equal to 1024"),
        ({"steps": 10**15}, "steps: given", "less than or equal to"),
        ({"validation": {"episodes": 10**12}}, "validation.episodes: given", "100000"),
        ({"validation": {"every_steps": 10**15}}, "validation.every_steps: given", "less than"),
        ({"imitation": {"decisions": 10**12}}, "imitation.decisions: given", "50000000"),
        ({"steps": "3e6"}, "steps: given '3e6'", "valid integer"),
        ({"asymmetric_critic": "yes"}, "asymmetric_critic: given 'yes'", "valid boolean"),
        ({"learning_rate": 1e-300}, "learning_rate: given 1e-300", "sizes of"),
        ({"learning_rate": "fast"}, "learning_rate: given 'fast'", "valid number"),
        ({"algorithm": "td3", "lagrangian": {"limit": 1.0}}, "lagrangian: ... 'td3'", "'ppo'"),
        ({"lagrangian": {}}, "lagrangian.limit", "required"),
        ({"lagrangian": {"limit": -1.0}}, "lagrangian.limit: given -1.0", "0"),
        ({"lagrangian": {"limit": 1.0, "rate": 0.0}}, "lagrangian.rate: given 0.0", "0"),
        ({"algorithm": "sac", "imitation": {}}, "given with algorithm 'sac'", "'ppo'"),
        ({"algorithm": "sac", "asymmetric_critic": True}, "given with algorithm 'sac'", "'ppo'"),
        (
            {"algorithm": "dagger", "imitation": {}, "asymmetric_critic": True},
            "asymmetric_critic: given with algorithm 'dagger'",
            "'ppo'",
        ),
        ({"imitation": {}, "residual": {"base": "ssm"}}, "residual: ... imitation", "one"),
        ({"residual": {"base": "ssm", "scale": 0.0}}, "residual.scale: given 0.0", "0"),
    ],
)
def test_bad_values_are_one_line_with_field_and_what_is_allowed(
    change: dict[str, Any], field: str, allowed: str
) -> None:
    with refused(f"{field} ... {allowed}"):
        load_training(**change)
