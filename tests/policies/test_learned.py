from __future__ import annotations

import sys
import zipfile
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
import torch
from gymnasium.wrappers import RescaleObservation
from sb3_contrib import QRDQN, TQC, CrossQ
from stable_baselines3 import DQN, PPO

from hazbot_gym import policies
from hazbot_gym.errors import MissingExtra
from hazbot_gym.policies import learned
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import describe, write
from hazbot_gym.policies.base import spec_of
from hazbot_gym.policies.layer import Layer
from hazbot_gym.task.observation import layout_for
from tests.refusals import refused


def save(
    path: Path,
    tier: str,
    bias: float,
    residual: dict[str, Any] | None = None,
    ring: Literal["paper", "six"] = "paper",
) -> Path:
    """Write an actor that always answers the same, alone or as a correction."""
    width = layout_for(tier, ring).width
    layer = Layer(np.zeros((width, 1), np.float32), np.array([bias], np.float32))
    with path.open("wb") as file:
        actor = Actor((layer,), "tanh", "clipped")
        write(describe(actor, algorithm="PPO", tier=tier, residual=residual), file)
    return path


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return save(tmp_path / "policy.npz", "tracks", 0.25)


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "shipped"
    folder.mkdir()
    monkeypatch.setattr(learned, "SHIPPED", folder)
    return folder


@pytest.mark.parametrize("form", ["learned:path={}", "learned:{}"])
def test_a_trained_policy_is_made_from_its_file(form: str, file: Path) -> None:
    policy = policies.make(form.format(file))
    assert isinstance(policy, policies.Policy)
    one, state = policy.predict(np.zeros(51, np.float32), state="kept")
    many, _ = policy.predict(np.zeros((3, 51), np.float32))
    assert (one.tolist(), state) == ([0.25], "kept")
    assert many.tolist() == [[0.25]] * 3
    assert one.dtype == np.float32


@pytest.mark.parametrize(
    "name", ["a,b", "a=b", "path=x", "a:b", " a ", "a,path=b", "[x]", "ü", "a,allow_pickle=true"]
)
@pytest.mark.parametrize("form", ["learned:path={}", "learned:{}"])
def test_a_path_may_have_any_letters(
    form: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).mkdir()
    save(tmp_path / name / "p,q=r.npz", "tracks", 0.25)

    policy = policies.make(form.format(f"./{name}/p,q=r.npz"))

    assert policy.predict(np.zeros(51, np.float32))[0].tolist() == [0.25]
    assert policies.make(spec_of("learned", {"path": tmp_path / name / "p,q=r.npz"}))


def test_a_policy_trained_with_six_sensors_acts_with_six_only(tmp_path: Path) -> None:
    policy = policies.make(f"learned:{save(tmp_path / 'six.npz', 'sonar', 0.25, ring='six')}")

    assert policy.predict(np.zeros(14, np.float32))[0].tolist() == [0.25]
    with refused("sensors.ring ... 4 range sensors ... 6"):
        policy.predict(np.zeros(12, np.float32))


def test_a_zip_that_no_model_is_in_is_one_line() -> None:
    with refused("model ... Stable-Baselines3"):
        policies.make("learned:nowhere.zip", allow_pickle=True)


def test_it_needs_no_torch(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("torch", "stable_baselines3", "sb3_contrib"):
        monkeypatch.setitem(sys.modules, name, None)
    policies.make(f"learned:{file}").predict(np.zeros(51, np.float32))


def test_another_tier_and_drawn_actions_are_refused_in_one_line(file: Path) -> None:
    policy = policies.make(f"learned:{file}")
    with refused("tier ... 12 ... tracks"):
        policy.predict(np.zeros(12, np.float32))
    with refused("sensors.ring ... 6 range sensors ... 4"):
        policy.predict(np.zeros(53, np.float32))
    with refused("deterministic ... False"):
        policy.predict(np.zeros(51, np.float32), deterministic=False)


@pytest.mark.parametrize(
    ("spec", "complaint"),
    [
        ("learned:nowhere.npz", "'nowhere.npz'"),
        ("learned:{here}", "damaged"),
        ("learned:model.zip", "model.zip ... --allow-pickle"),
        ("learned:nowhere.zip,allow_pickle=true", "--allow-pickle"),
        ("learned", "'learned' ... learned:path=FILE"),
        ("learned:path=", "'learned:path='"),
    ],
)
def test_mistakes_are_one_line(spec: str, complaint: str) -> None:
    with refused(complaint):
        policies.make(spec.format(here=__file__))


# --- zips of Stable-Baselines3 -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("algorithm", "levels"), [(PPO, 0), (TQC, 0), (CrossQ, 0), (DQN, 5), (QRDQN, 5)]
)
def test_a_zip_is_loaded_where_that_is_allowed(
    algorithm: Any, levels: int, tmp_path: Path, blank: Any, seen: Any
) -> None:
    model = algorithm("MlpPolicy", blank(levels=levels), seed=0, device="cpu")
    model.save(tmp_path / "model.zip")
    policy = policies.make(f"learned:{tmp_path / 'model.zip'}", allow_pickle=True)
    expected, _ = model.predict(seen(), deterministic=True)
    actions, _ = policy.predict(seen())
    assert actions == pytest.approx(expected[:, None] / 2 - 1 if levels else expected)
    with refused("tier ... 12"):
        policy.predict(np.zeros(12, np.float32))
    with refused("deterministic ... False"):
        policy.predict(np.zeros(51, np.float32), deterministic=False)


def test_a_zip_that_observed_through_a_wrapper_is_refused(
    tmp_path: Path, blank: Any, seen: Any
) -> None:
    env = RescaleObservation(blank(), np.float32(-1), np.float32(1))
    PPO("MlpPolicy", env, device="cpu").save(tmp_path / "model.zip")
    policy = policies.make(f"learned:{tmp_path / 'model.zip'}", allow_pickle=True)
    with refused("policy ... from -1 to 1 ... no wrapper"):
        policy.predict(seen())


@pytest.mark.parametrize("data", ["[" * 100_000, "{}", '{"policy_class": 3}', "\x00"])
def test_a_zip_whose_description_is_none_is_one_line(data: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "model.zip", "w") as archive:
        archive.writestr("data", data)
    with refused("model ... Stable-Baselines3"):
        policies.make(f"learned:{tmp_path / 'model.zip'}", allow_pickle=True)


def test_a_zip_of_broken_weights_or_damaged_pickles_is_one_line(blank: Any, tmp_path: Path) -> None:
    model, path = PPO("MlpPolicy", blank(), device="cpu"), tmp_path / "model.zip"
    with torch.no_grad():
        model.policy.action_net.weight[0, 0] = torch.nan
    model.save(path)
    with refused("weights ... finite"):
        policies.make(f"learned:{path}", allow_pickle=True)
    with zipfile.ZipFile(path) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in entries.items():
            archive.writestr(name, content[:-40] if name == "policy.pth" else content)
    with refused("model.zip"):
        policies.make(f"learned:{path}", allow_pickle=True)


def test_a_zip_without_the_extra_names_it(
    blank: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    PPO("MlpPolicy", blank(), device="cpu").save(tmp_path / "model.zip")
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    with refused("pip install 'hazbot-gym[train]'", error=MissingExtra):
        policies.make(f"learned:{tmp_path / 'model.zip'}", allow_pickle=True)


# --- the shipped ones ----------------------------------------------------------------------------


def test_ppo_is_the_shipped_policy_of_the_tier(shipped: Path) -> None:
    save(shipped / "ppo_tracks.npz", "tracks", 0.5)
    save(shipped / "ppo_sonar.npz", "sonar", -0.5)
    policy = policies.make("ppo")
    assert policy.predict(np.zeros((2, 51), np.float32))[0].tolist() == [[0.5], [0.5]]
    assert policy.predict(np.zeros(12, np.float32))[0].tolist() == [-0.5]


def test_a_shipped_correction_drives_on_its_base(shipped: Path) -> None:
    save(shipped / "ppo_tracks.npz", "tracks", 0.5, {"base": "constant:0.25", "scale": 0.4})
    actions, _ = policies.make("ppo").predict(np.zeros((2, 51), np.float32))
    np.testing.assert_allclose(actions, [[-0.5 + 0.4 * 0.5]] * 2)


def test_a_tier_that_none_is_shipped_for_is_one_line(shipped: Path) -> None:
    save(shipped / "ppo_tracks.npz", "tracks", 0.5)
    with refused("tier ... 12"):
        policies.make("ppo").predict(np.zeros(12, np.float32))


def test_no_shipped_policy_is_one_line(shipped: Path) -> None:
    with refused("policy ... 'ppo'"):
        policies.make("ppo")
