from __future__ import annotations

import gymnasium
import pytest

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE, register_environments

NAMES = list(ENVIRONMENTS)


def test_the_ids_are_those_of_the_field() -> None:
    assert set(NAMES) == {
        "Corridor-v1",
        "Crossing-v1",
        "Encountering-v1",
        "Leading-v1",
        "Confronting-v1",
        "Circle-v1",
        "Intersection-v1",
        "Doorway-v1",
        "Aisle-v1",
        "Inspection-v1",
        "InspectionEmpty-v1",
        "Replay-v1",
    }


@pytest.mark.parametrize("name", NAMES)
def test_every_id_is_registered_with_a_sentence_and_makes_one_class(name: str) -> None:
    sentence, preset = ENVIRONMENTS[name]
    assert sentence.endswith(".")
    env = gymnasium.make(f"{NAMESPACE}/{name}")
    assert type(env.unwrapped) is CorridorEnv
    assert env.spec is not None
    assert env.spec.kwargs["preset"] == preset


@pytest.mark.parametrize("name", NAMES)
def test_gymnasium_s_horizon_is_the_environment_s_own(name: str) -> None:
    env = gymnasium.make(f"{NAMESPACE}/{name}")
    assert env.spec is not None
    assert isinstance(env.unwrapped, CorridorEnv)
    assert env.spec.max_episode_steps == env.unwrapped.config.max_episode_steps


def test_registering_again_changes_nothing() -> None:
    before = {env_id: spec for env_id, spec in gymnasium.registry.items() if NAMESPACE in env_id}
    register_environments()
    after = {env_id: spec for env_id, spec in gymnasium.registry.items() if NAMESPACE in env_id}
    assert len(before) == len(NAMES)
    assert all(after[env_id] is spec for env_id, spec in before.items())
    assert len(after) == len(before)


@pytest.mark.parametrize("family", ["crossing", "encountering", "leading", "confronting"])
def test_a_family_s_id_asks_for_that_family(family: str) -> None:
    env = gymnasium.make(f"{NAMESPACE}/{family.capitalize()}-v1").unwrapped
    assert isinstance(env, CorridorEnv)
    assert env.config.people.family == family


def test_overrides_are_laid_over_the_preset_of_the_id() -> None:
    env = gymnasium.make(f"{NAMESPACE}/Crossing-v1", people={"count": [2, 2]}).unwrapped
    assert isinstance(env, CorridorEnv)
    assert env.config.people.count == (2, 2)
    assert env.config.people.family == "crossing"
