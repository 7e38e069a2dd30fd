from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest
import torch
from rich.console import Console
from stable_baselines3 import SAC

from hazbot_gym.envs.sb3 import CorridorVecEnv
from hazbot_gym.training.checkpoints import load_newest, restore, save, state_of

QUIET = Console(quiet=True)


def model(steps: int = 0, seed: int = 0) -> SAC:
    envs = CorridorVecEnv(2, seed=0, max_episode_steps=10)
    options: dict[str, Any] = {"batch_size": 8, "learning_starts": 10, "buffer_size": 40}
    made = SAC(
        "MlpPolicy", envs, seed=seed, device="cpu", policy_kwargs={"net_arch": [4]}, **options
    )
    return made.learn(steps) if steps else made


def flat(nest: Any) -> list[Any]:
    if isinstance(nest, dict):
        return [leaf for value in nest.values() for leaf in flat(value)]
    if isinstance(nest, list):
        return [leaf for value in nest for leaf in flat(value)]
    return [nest.tolist() if isinstance(nest, torch.Tensor) else nest]


@pytest.mark.parametrize("steps", [30, 100])  # the replay buffer not yet full, and full
def test_a_model_comes_back_with_optimisers_counters_and_buffer(steps: int, tmp_path: Path) -> None:
    trained, other = model(steps), model(seed=1)
    save(tmp_path, trained, {"begun": 3})
    found = load_newest(tmp_path, QUIET)
    assert found is not None
    restore(other, found["model"])
    assert flat(state_of(other)) == flat(state_of(trained))
    assert other.num_timesteps == trained.num_timesteps >= steps
    assert other.ent_coef_optimizer.param_groups[0]["params"][0] is other.log_ent_coef
    assert found["progress"] == {"begun": 3}


def test_two_are_kept_and_the_newest_is_read(tmp_path: Path) -> None:
    trained = model()
    for steps in (10, 20, 30):
        trained.num_timesteps = steps
        save(tmp_path, trained, {"at": steps})
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "000000000020.pt",
        "000000000030.pt",
    ]
    found = load_newest(tmp_path, QUIET)
    assert found is not None
    assert found["progress"] == {"at": 30}


@pytest.mark.parametrize(
    "damage", [lambda b: b[:-1], lambda b: b"", lambda b: b[:99] + b"x" + b[100:]]
)
def test_damaged_ones_are_passed_over_and_said_so(damage: Any, tmp_path: Path) -> None:
    trained = model()
    for steps in (10, 20):
        trained.num_timesteps = steps
        save(tmp_path, trained, {"at": steps})
    told = io.StringIO()
    for path, left in (("000000000020.pt", {"at": 10}), ("000000000010.pt", None)):
        (tmp_path / path).write_bytes(damage((tmp_path / path).read_bytes()))
        found = load_newest(tmp_path, Console(file=told, width=200))
        assert (found and found["progress"]) == left
    assert "checkpoint 000000000020.pt is damaged, the one before it is used" in told.getvalue()


def test_a_write_that_is_cut_off_leaves_the_last_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trained = model()
    save(tmp_path, trained, {"at": 0})
    trained.num_timesteps = 10

    def cut_off(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "replace", cut_off)
    with pytest.raises(KeyboardInterrupt):
        save(tmp_path, trained, {"at": 10})
    (tmp_path / ".000000000010.pt.x.tmp").write_bytes(b"half")
    found = load_newest(tmp_path, QUIET)
    assert found is not None
    assert found["progress"] == {"at": 0}
    assert [path.name for path in tmp_path.iterdir()] == ["000000000000.pt"]


def test_reading_one_runs_nothing_that_is_in_it(tmp_path: Path) -> None:
    save(tmp_path, model(), {"evil": Path("/")})  # any class stands for code
    assert load_newest(tmp_path, QUIET) is None


def test_one_of_another_run_is_passed_over(tmp_path: Path) -> None:
    save(tmp_path, model(), {"run": "another"})
    with open(tmp_path / "told.txt", "w", encoding="utf-8") as told:
        assert load_newest(tmp_path, Console(file=told, width=200), "this") is None
    assert "another run's" in (tmp_path / "told.txt").read_text(encoding="utf-8")
    assert load_newest(tmp_path, QUIET, "another") is not None
