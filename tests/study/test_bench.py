from __future__ import annotations

import io

import gymnasium
from rich.console import Console

from hazbot_gym.study.bench import CARTPOLE, CORRIDOR, Effort, Stepper, bench, table


def test_bench_measures_both_environments_in_the_same_run() -> None:
    result = bench(Effort(turns=2, corridor_steps=50, cartpole_steps=50))
    ours, theirs = result[CORRIDOR]["steps_per_s"], result[CARTPOLE]["steps_per_s"]
    assert ours > 0
    assert theirs > 0
    assert 0.0 < result["ratio"] < 10.0
    assert result["machine"]["cores"] >= 1
    shown = io.StringIO()
    Console(file=shown, width=120).print(table(result))
    for text in (CORRIDOR, CARTPOLE, "ratio", "fuzzy-PID"):
        assert text in shown.getvalue()


def test_stepping_goes_on_over_the_end_of_an_episode() -> None:
    env = gymnasium.wrappers.RecordEpisodeStatistics(gymnasium.make(CARTPOLE))
    Stepper(env).run(500)
    assert env.episode_count > 5
