"""The trained policies that come with the library."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.evaluation.metrics import means
from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.policies.actor_file import card, read
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.study.config import load_study
from hazbot_gym.task.observation import LAYOUTS, layout_for
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.utils.files import read_json
from tests.refusals import refused

ROOT = Path(__file__).parents[2]
CONFIGS, RECORDS = ROOT / "configs", ROOT / "benchmarks"
TRAINED_BY = {"tracks": "ppo_from_rules.yaml", "sonar": "ppo_residual_sonar.yaml"}
LARGEST_BYTES = 200_000

tiers = pytest.mark.parametrize("tier", ["tracks", "sonar"])


@tiers
def test_it_is_small_and_says_by_which_config_it_comes_again(tier: str) -> None:
    path = SHIPPED / f"ppo_{tier}.npz"
    assert path.stat().st_size < LARGEST_BYTES
    about = read(path).about
    assert about["tier"] == tier
    seed = about["training"]["seed"]
    config = load_training(CONFIGS / TRAINED_BY[tier], seed=seed)
    assert TrainConfig.model_validate(about["training"]["config"]) == config


def test_its_card_says_what_it_reached_in_the_study() -> None:
    record = read_json(RECORDS / "study.json")["shipped"]["sets"]["test"]["ppo from rules"]
    found = read(SHIPPED / "ppo_tracks.npz").about["study"]
    assert found["delay_s"].startswith(f"{record['metrics']['delay_s']['mean']:.4g} ")


def test_the_study_of_it_has_what_trained_it_and_the_rules_that_it_started_from() -> None:
    study = load_study(CONFIGS / "study_from_rules.yaml")
    assert [each.config.name for each in study.learners] == [TRAINED_BY["tracks"]]
    started = set(load_training(CONFIGS / TRAINED_BY["tracks"]).teachers())
    assert started & set(study.names)


@tiers
def test_its_card_is_that_of_the_file(tier: str) -> None:
    path = SHIPPED / f"ppo_{tier}.npz"
    assert path.with_suffix(".md").read_text(encoding="utf-8") == card(read(path), path.stem)


@tiers
def test_it_drives_on_an_empty_floor_and_stops_for_nobody(tier: str) -> None:
    found = means(
        evaluate(
            "ppo",
            "hazbot_gym/Corridor-v1",
            episodes=3,
            overrides={"tier": tier, "people": {"count": [0, 0]}},
        )
    )
    assert found["arrived"] == 1.0
    assert found["delay_s"] < 5.0


@pytest.mark.parametrize(
    ("tier", "env"),
    # Not Crossing with four ultrasonic sensors: people come from where they do not look.
    [("tracks", "Crossing"), ("sonar", "Encountering")],
)
def test_it_arrives_without_driving_into_anybody(tier: str, env: str) -> None:
    overrides = {"tier": tier}
    found = means(evaluate("ppo", f"hazbot_gym/{env}-v1", episodes=30, seed=9, overrides=overrides))
    assert found["arrived"] > 0.9
    assert found["contacts_per_km"] == 0.0


@pytest.mark.parametrize("tier", ["sonar", "tracks"])
def test_it_is_refused_for_a_ring_of_six(tier: str) -> None:
    with refused("sensors.ring ... 6 ... 'ppo'"):
        policies.make("ppo").predict(np.zeros(layout_for(tier, "six").width, np.float32))


def test_one_name_serves_both_tiers() -> None:
    policy = policies.make("ppo")
    for tier in ("tracks", "sonar"):
        actions, _ = policy.predict(np.zeros((2, LAYOUTS[tier].width), np.float32))
        assert actions.shape == (2, 1)
