"""The scripts of ``eval/`` and ``train/`` run from top to bottom."""

from __future__ import annotations

import runpy
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest

from hazbot_gym.utils.files import read_json

ROOT = Path(__file__).parents[1]


def run(script: str, *arguments: str, folder: Path) -> str:
    command = [sys.executable, str(ROOT / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def run_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., str]:
    """Return a function that runs a script in this process, which has loaded torch already."""

    def run(script: str, *arguments: str) -> str:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", [script, *arguments])
        runpy.run_path(str(ROOT / script), run_name="__main__")
        return capsys.readouterr().out

    return run


def test_a_policy_is_evaluated(tmp_path: Path) -> None:
    text = run("eval/evaluate_policy.py", "--episodes", "1", folder=tmp_path)
    assert "personal_m" in text


def test_policies_are_compared(tmp_path: Path) -> None:
    arguments = ["constant:1.0", "constant:0.5", "--sets", "Crossing", "--episodes", "2"]
    text = run("eval/compare_policies.py", *arguments, folder=tmp_path)
    assert "constant:0.5 minus constant:1.0" in text
    assert (tmp_path / "results" / "compare_policies" / "summary.json").exists()


@pytest.mark.slow
def test_ppo_is_trained_and_compared(run_here: Callable[..., str], tmp_path: Path) -> None:
    config = tmp_path / "tiny.yaml"
    config.write_text(
        "options: {n_steps: 16, batch_size: 64, n_epochs: 1}\n"
        "network: {net_arch: [4]}\n"
        "validation: {episodes: 1}\n"
    )
    arguments = ["--config", str(config), "--steps", "64", "--worlds", "4", "--episodes", "1"]
    text = run_here("train/train_ppo.py", *arguments)
    assert "fuzzy_expert" in text
    assert (tmp_path / "results" / "train_ppo" / "policy.npz").exists()


TINY = (
    "options: {n_steps: 16, batch_size: 64, n_epochs: 1}\n"
    "network: {net_arch: [4]}\n"
    "steps: 128\nworlds: 4\n"
    "validation: {episodes: 1, every_steps: 64}\n"
)


@pytest.mark.slow
def test_a_reward_term_and_people_of_one_s_own_are_trained_with(tmp_path: Path) -> None:
    config = tmp_path / "tiny.yaml"
    config.write_text(TINY)
    arguments = ["--config", str(config), "--episodes", "1"]
    text = run("train/own_reward_and_people.py", *arguments, folder=tmp_path)
    assert "fuzzy_expert: return" in text
    assert text.count("crowding 0.00 s") < 2  # people come near the robot


@pytest.mark.slow
def test_a_curriculum_over_randomised_scenarios_is_trained_with(
    run_here: Callable[..., str], tmp_path: Path
) -> None:
    config = tmp_path / "tiny.yaml"
    config.write_text(TINY)
    arguments = ["--config", str(config), "--episodes", "1"]
    text = run_here("train/own_curriculum.py", *arguments)
    assert "from decision 0 on: 1 to 2 people" in text
    assert "from decision 64 on: 1 to" in text
    assert "fuzzy_expert: return" in text


@pytest.mark.slow
def test_sac_is_trained_by_hand_and_exported(run_here: Callable[..., str], tmp_path: Path) -> None:
    text = run_here("train/train_sac.py", "--steps", "120", "--worlds", "2")
    assert "results/train_sac/policy.npz" in text
    assert (tmp_path / "results" / "train_sac" / "policy.md").exists()


@pytest.mark.slow
@pytest.mark.parametrize("method", ["bc", "td3_bc"])
def test_a_policy_is_trained_from_a_data_set(
    method: str, run_here: Callable[..., str], tmp_path: Path
) -> None:
    pytest.importorskip("minari")
    if method == "td3_bc" and find_spec("d3rlpy") is None:
        pytest.skip("d3rlpy is not installed")
    from hazbot_gym.evaluation.minari_dataset import write_dataset

    horizon = {"max_episode_steps": 40}
    write_dataset(
        "constant:0.5", "Crossing-v1", tmp_path / "half-v0", episodes=8, overrides=horizon
    )

    limits = ["--epochs", "200", "--updates", "20", "--episodes", "2", "--json", "found.json"]
    run_here("train/offline.py", "half-v0", "--method", method, *limits)

    found = read_json(tmp_path / "found.json")
    assert found["decisions"] == 8 * 40
    if method == "bc":
        assert found["trained"]["return"] == pytest.approx(found["recorded"]["return"], abs=0.5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nowhere-v0",), "dataset: given nowhere-v0, no folder of hazbot dataset"),
        (
            ("nowhere-v0", "--updates", "0"),
            "--updates: given '0', allowed are integers of at least",
        ),
        (("nowhere-v0", "--out", "policy"), "--out: given policy, allowed is a new file that ends"),
    ],
)
def test_mistakes_are_told_before_training_from_a_data_set(
    arguments: tuple[str, ...],
    said: str,
    run_here: Callable[..., str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("minari")
    with pytest.raises(SystemExit, match="2"):
        run_here("train/offline.py", *arguments)
    assert said in capsys.readouterr().err


@pytest.mark.slow
def test_an_algorithm_of_one_s_own_is_exported_and_evaluated(
    run_here: Callable[..., str], tmp_path: Path
) -> None:
    tiny = ["--generations", "2", "--actors", "8", "--worlds-each", "2", "--decisions", "20"]
    text = run_here("train/own_algorithm.py", *tiny)
    assert "results/own_algorithm/policy.npz" in text


@pytest.mark.slow
@pytest.mark.clients
def test_ppo_of_rllib_is_exported_and_evaluated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ray.rllib", reason="needs ray[rllib]: make client-rllib")
    monkeypatch.setenv("RAY_raylet_start_wait_time_s", "300")  # slow machines take minutes
    tiny = ["--decisions", "1024", "--worlds", "16", "--horizon", "32", "--episodes", "1"]
    text = run("train/rllib_ppo.py", *tiny, folder=tmp_path)
    print(text)
    assert (tmp_path / "results" / "rllib_ppo" / "policy.npz").exists()
    assert "saved to" in text
