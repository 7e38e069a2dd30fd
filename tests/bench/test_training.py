"""The benchmark of training: what it records of a tiny run, and what it refuses."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console
from typer.testing import CliRunner

from hazbot_gym import cli
from hazbot_gym.bench import training, training_report
from hazbot_gym.bench.training import goals, speed_cases
from hazbot_gym.errors import MissingExtra
from hazbot_gym.training.config import load_training
from tests.refusals import refused

TINY = """
algorithm: ppo
worlds: 16
steps: 128
overrides: {max_episode_steps: 30}
options: {n_steps: 8, batch_size: 64, n_epochs: 1}
network: {net_arch: [4]}
validation: {every_steps: 64, episodes: 2}
"""


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    path = tmp_path_factory.mktemp("bench") / "tiny.yaml"
    path.write_text(TINY, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(training, "TURNS", 1)
        patch.setattr(training, "UPDATES", 2)
        patch.setattr(training, "CARTPOLE_STEPS", 1_000)
        return training.bench_training([path], seeds=1, episodes=8)


def test_a_run_is_measured_whole_and_judged_beside_the_expert(record: dict[str, Any]) -> None:
    found = record["runs"]["tiny.yaml"]
    (run,) = found["runs"]
    assert run["steps"] == 128
    assert run["seconds"] > 1.0  # it has started Python and loaded torch
    assert run["peak_bytes"] > 1e8
    metrics, expert = run["metrics"], found["expert"]
    assert metrics["return"]["mean"] != expert["return"]["mean"]
    is_better = metrics["return"]["mean"] > expert["return"]["mean"]
    assert run["is_better_paid"] == is_better
    told = found["goals"]
    reached = run["seconds"] if run["is_better_paid"] else None
    assert told["seconds to a return above the fuzzy expert's, median"]["measured"] == reached
    speed = found["speed"]
    assert speed["ratio"] == pytest.approx(speed["batched"] / speed["pymunk"])
    assert speed["to_cartpole"] == pytest.approx(speed["batched"] / speed["cartpole"])


def test_it_is_shown_on_the_terminal(record: dict[str, Any]) -> None:
    told = io.StringIO()
    Console(width=160, file=told).print(training_report.table(record))
    assert "tiny.yaml" in told.getvalue()


def test_seconds_count_only_where_something_was_reached() -> None:
    def run(seconds: float, *, is_dominated: bool) -> dict[str, Any]:
        return {"seconds": seconds, "peak_bytes": 2e9, "is_dominated": is_dominated,
                "is_better_paid": False}  # fmt: skip

    runs = [
        run(50.0, is_dominated=False),
        run(10.0, is_dominated=True),
        run(40.0, is_dominated=False),
    ]
    found = goals(runs, {"batched": 60_000, "to_cartpole": 1.5, "ratio": 9.0})
    measured = [goal["measured"] for goal in found.values()]
    assert measured == [60_000.0, 1.5, 9.0, 50.0, None, 2.0]


@pytest.mark.parametrize("name", ["ppo", "ppo_from_rules"])
def test_the_reference_makes_updates_of_the_same_size(name: str) -> None:
    path = Path(__file__).parents[2] / "configs" / f"{name}.yaml"
    config = load_training(path)
    sizes = set()
    for changes in speed_cases(config).values():
        run = config.model_copy(update=changes)
        sizes.add(run.options["n_steps"] * run.worlds)
    assert sizes == {config.options["n_steps"] * config.worlds}


def test_only_ppo_is_measured() -> None:
    path = Path(__file__).parents[2] / "configs" / "sac.yaml"
    with refused("training ... sac.yaml ... 'sac'"):
        training.bench_training([path])


def test_without_the_extra_nothing_is_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "hazbot_gym.training.run", raising=False)
    monkeypatch.setitem(sys.modules, "sb3_contrib", None)
    with refused("sb3-contrib ... hazbot-gym[train]", error=MissingExtra):
        training.bench_training([])


def test_what_training_refuses_is_no_traceback(tmp_path: Path) -> None:
    file = tmp_path / "run.yaml"
    file.write_text(TINY)
    with (
        refused("training ... run.yaml"),
        training.trained(file, steps=-1),
    ):
        pass


def test_the_command_says_which_file_it_cannot_read(tmp_path: Path) -> None:
    missing = str(tmp_path / "none.yaml")
    done = CliRunner().invoke(cli.app, ["bench", "--training", missing])
    assert done.exit_code == 2
    assert "none.yaml" in done.output


def test_a_teacher_that_runs_may_not_load_is_refused_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(training, "judge", lambda *_: pytest.fail("work has begun"))
    (tmp_path / "expert.zip").write_bytes(b"PK")
    file = tmp_path / "run.yaml"
    file.write_text(f"imitation: {{teacher: 'learned:path={tmp_path}/expert.zip'}}\n")
    with refused("pickle"):
        training.bench_training([file])
