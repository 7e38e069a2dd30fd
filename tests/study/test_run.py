from __future__ import annotations

import io
import os
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd
import pytest
from rich.console import Console

from hazbot_gym.evaluation import workers
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.study import candidates, store
from hazbot_gym.study.config import Oracle, StudyConfig, load_study
from hazbot_gym.study.run import StoredShard, plan, plan_oracle, run_study
from hazbot_gym.study.stamps import Stamps
from hazbot_gym.utils import files, provenance
from tests.refusals import refused, says

CODE = Permissions(allow_code=True)
STUDY = load_study(
    policies=["constant:1.0", "constant:0.5"],
    sets=["Encountering", "Crossing"],
    episodes=3,
    episodes_per_shard=2,
    resamples=100,
    engine="pymunk",
)


class InlinePool:
    """Runs shards at once in this process, which is quicker than starting others."""

    shards: ClassVar[list[Any]] = []

    def __init__(self, *args: object, **kwargs: object) -> None:
        InlinePool.shards = []

    def submit(self, run: Callable[[Any], Any], shard: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(run(shard))
        self.shards.append(shard)
        return future

    def shutdown(self, **kwargs: object) -> None:
        pass


@pytest.fixture
def inline(monkeypatch: pytest.MonkeyPatch) -> type[InlinePool]:
    monkeypatch.setattr(workers, "Processes", InlinePool)
    monkeypatch.setattr(InlinePool, "shards", [])
    return InlinePool


@pytest.fixture(scope="module")
def parallel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The study as two real processes run it."""
    out = tmp_path_factory.mktemp("study") / "out"
    run_study(STUDY, out, workers=2)
    return out


def planned(out: Path) -> Iterator[StoredShard]:
    return plan(STUDY, out, candidates.of_study(STUDY, out))


def said(run: Callable[[Console], object]) -> str:
    out = io.StringIO()
    run(Console(file=out, width=200))
    return out.getvalue()


def contents(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_a_study_leaves_one_row_an_episode_in_a_fixed_order(parallel: Path) -> None:
    rows = pd.read_parquet(parallel / store.EPISODES)
    found = list(rows[["scenario_set", "policy", "episode"]].itertuples(index=False, name=None))
    assert found == [
        (scenarios, policy, episode)
        for scenarios in ("Encountering", "Crossing")
        for policy in STUDY.policies
        for episode in range(3)
    ]


def test_no_two_policies_sets_or_seeds_share_a_shard(tmp_path: Path) -> None:
    sets = [{"name": name, "env": "hazbot_gym/Circle-v1"} for name in ("set", "b--set", "SET")]
    study = load_study(sets=sets, episodes=2, episodes_per_shard=1)
    names = {"a": 2, "a-1": 1, "a--b": 1, "A": 1, "best drive": 1, "long" * 99: 1, "я" * 199: 1}
    policies = [
        candidates.Candidate(name, ("constant:0.5",) * seeds) for name, seeds in names.items()
    ]
    oracle = Oracle(sets=("set", "b--set", "SET"))
    shards = [
        *plan(study, tmp_path, policies),
        *plan_oracle(study.model_copy(update={"oracle": oracle}), tmp_path, policies),
    ]
    paths = [shard.path.name.casefold() for shard in shards]
    assert len(paths) == len(set(paths)) == 8 * 3 * 2 + 3
    assert all(len(os.fsencode(path)) < 255 for path in paths)


def test_a_manifest_says_where_the_numbers_come_from(parallel: Path) -> None:
    manifest = files.read_json(parallel / store.MANIFEST)
    assert manifest["study"] == STUDY.identity()
    assert StudyConfig.model_validate(manifest["config"]) == STUDY
    assert manifest["environments"]["Encountering"]["people"]["model"] == "social_force"
    assert manifest["versions"]["gymnasium"]
    assert manifest["started"].endswith("+00:00")


def test_neither_workers_nor_processes_change_a_byte(
    parallel: Path, inline: type[InlinePool], tmp_path: Path
) -> None:
    run_study(STUDY, tmp_path, workers=1)
    here, there = contents(tmp_path), contents(parallel)
    assert here.keys() == there.keys()
    differing = {name for name in here if here[name] != there[name]}
    assert differing <= {store.MANIFEST, store.COSTS}


def test_the_batched_engine_gives_the_same_rows(parallel: Path, tmp_path: Path) -> None:
    run_study(STUDY.model_copy(update={"engine": "batched"}), tmp_path, workers=1)
    rows, reference = (pd.read_parquet(out / store.EPISODES) for out in (tmp_path, parallel))
    pd.testing.assert_frame_equal(rows, reference, rtol=1e-6, atol=1e-6)


def test_a_single_shard_runs_in_this_process_on_threads(
    inline: type[InlinePool], tmp_path: Path
) -> None:
    study = load_study(policies=["constant:1.0"], sets=["Encountering"], episodes=40, resamples=100)
    for count in (1, 2):
        run_study(study, tmp_path / str(count), workers=count)
    one, two = (contents(tmp_path / str(count)) for count in (1, 2))
    assert {name for name in one if one[name] != two[name]} <= {store.MANIFEST, store.COSTS}
    assert inline.shards == []


def test_a_finished_study_is_not_run_again(inline: type[InlinePool], parallel: Path) -> None:
    before = contents(parallel)
    text = said(lambda console: run_study(STUDY, parallel, workers=2, console=console))
    assert inline.shards == []
    assert "8 of 8" in text
    assert contents(parallel) == before


def test_an_interrupted_study_goes_on_where_it_stopped(
    inline: type[InlinePool], parallel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = []

    def write_three(*arguments: Any) -> None:
        if len(written) == 3:
            raise KeyboardInterrupt
        written.append(write_rows(*arguments))

    write_rows = store.write_rows
    monkeypatch.setattr(store, "write_rows", write_three)
    with pytest.raises(KeyboardInterrupt):
        run_study(STUDY, tmp_path, workers=2)
    monkeypatch.setattr(store, "write_rows", write_rows)
    assert not (tmp_path / store.EPISODES).exists()
    assert not (tmp_path / store.SUMMARY).exists()
    assert len(list((tmp_path / store.SHARDS).iterdir())) == 3

    run_study(STUDY, tmp_path, workers=2)
    assert len(inline.shards) == 5
    assert (tmp_path / store.SUMMARY).read_bytes() == (parallel / store.SUMMARY).read_bytes()


def test_a_damaged_shard_is_run_again_and_said_so(
    inline: type[InlinePool], parallel: Path, tmp_path: Path
) -> None:
    shutil.copytree(parallel, tmp_path, dirs_exist_ok=True)
    before = contents(tmp_path)
    shards = [shard.path for shard in planned(tmp_path)]
    shards[2].write_bytes(shards[2].read_bytes()[:100])
    shards[5].unlink()
    text = said(lambda console: run_study(STUDY, tmp_path, workers=2, console=console))
    assert "6 of 8" in text
    assert "1 damaged shard" in text
    assert len(inline.shards) == 2
    after = contents(tmp_path)
    changed = {name for name in after if after[name] != before[name]}
    assert changed <= {store.MANIFEST, store.COSTS}


def test_results_of_other_code_are_run_again_and_said_so(
    inline: type[InlinePool], parallel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(parallel, tmp_path, dirs_exist_ok=True)
    monkeypatch.setattr(provenance, "stamp", lambda data: "of other code")
    text = said(lambda console: run_study(STUDY, tmp_path, workers=2, console=console))
    says(text.replace("\n", " "), "8 ... other code")
    assert len(inline.shards) == 8


def test_results_are_withdrawn_until_what_they_rest_on_is_complete(
    inline: type[InlinePool], parallel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(parallel, tmp_path, dirs_exist_ok=True)
    next(planned(tmp_path)).path.unlink()

    def interrupt(*arguments: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(store, "write_rows", interrupt)
    with pytest.raises(KeyboardInterrupt):
        run_study(STUDY, tmp_path, workers=2)
    assert not (tmp_path / store.SUMMARY).exists()
    assert not (tmp_path / store.EPISODES).exists()


def test_an_edited_policy_of_ones_own_is_run_again_and_no_other(
    inline: type[InlinePool], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = tmp_path / "my_policy_under_test.py"
    text = (
        "import numpy as np\n"
        "class Mine:\n"
        "    def predict(self, observation, state=None, episode_start=None, deterministic=True):\n"
        "        return np.full((*np.shape(observation)[:-1], 1), 0.5, np.float32), state\n"
    )
    source.write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    study = load_study(
        policies=["constant:1.0", "my_policy_under_test:Mine"],
        sets=["Encountering"],
        episodes=2,
        episodes_per_shard=1,
    )
    run_study(study, tmp_path / "out", workers=2, allowed=CODE)
    assert len(inline.shards) == 4
    source.write_text(text + "# better\n")
    run_study(study, tmp_path / "out", workers=2, allowed=CODE)
    assert [shard.policy for shard in inline.shards] == ["my_policy_under_test:Mine"] * 2


def test_an_edited_place_is_run_again_and_no_other_set(
    inline: type[InlinePool], tmp_path: Path
) -> None:
    place = tmp_path / "lab.yaml"
    text = "{name: lab, walls: [[-2, 1.2, 14, 1.2]], path: {points: [[0, 0], [12, 0]]}}"
    place.write_text(text)
    alone = {"place": str(place), "people": {"count": [0, 0]}}
    sets = [{"name": "lab", "env": "hazbot_gym/Corridor-v1", "overrides": alone}]
    study = load_study(policies=["constant:1.0"], sets=["Encountering", *sets], episodes=2)
    run_study(study, tmp_path / "out", workers=1)
    before = pd.read_parquet(tmp_path / "out" / store.EPISODES)
    place.write_text(text.replace("12", "9"))
    told = said(lambda console: run_study(study, tmp_path / "out", workers=1, console=console))
    assert "1 of 2" in told
    says(told.replace("\n", " "), "1 ... other code")
    is_longer = before["time_s"] > pd.read_parquet(tmp_path / "out" / store.EPISODES)["time_s"]
    assert is_longer.tolist() == [False, False, True, True]


def test_no_number_and_no_stamp_depends_on_what_is_allowed(tmp_path: Path) -> None:
    policies = candidates.of_study(STUDY, tmp_path)
    plans = [
        list(plan(STUDY, tmp_path, policies, Stamps(STUDY, allowed))) for allowed in (CODE, NO_CODE)
    ]
    assert [each.stamp for each in plans[0]] == [each.stamp for each in plans[1]]
    assert {each.work.allowed for each in plans[0]} == {CODE}


@pytest.mark.slow
def test_workers_run_code_of_the_working_folder_where_that_is_allowed_and_nothing_else_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("yaml", "pandas", "hazbot_gym"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('run from the working folder')\n")
    (tmp_path / "of_this_folder.py").write_text(
        "from hazbot_gym.policies.constant import Constant\nhalf = Constant(0.5)\n"
    )
    study = load_study(
        policies=["constant:0.5", "of_this_folder:half"], sets=["E*"], episodes=1, resamples=100
    )

    run_study(study, tmp_path / "out", workers=2, allowed=CODE)

    rows = store.read_episodes(tmp_path / "out" / store.EPISODES)
    assert rows["return"].nunique() == 1
    assert set(rows["policy"]) == {"constant:0.5", "of_this_folder:half"}


def test_a_folder_of_another_study_is_refused_and_left_alone(
    inline: type[InlinePool], parallel: Path
) -> None:
    before = contents(parallel)
    with refused("holds another study"):
        run_study(STUDY.model_copy(update={"seed": 9}), parallel)
    assert inline.shards == []
    assert contents(parallel) == before


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"policies": ["constant:1.0", "constant:fraction=2"]}, "fraction"),
        ({"policies": ["telepathy"]}, "telepathy"),
        ({"policies": ["my_own:Policy"]}, "--allow-code"),
        ({"policies": ["learned:path=evil.zip"]}, "--allow-pickle"),
        ({"policies": ["learned:path=evil.zip,allow_pickle=true"]}, "--allow-pickle"),
        ({"sets": [{"name": "x", "env": "hazbot_gym/Nowhere-v1"}]}, "Nowhere"),
        (
            {
                "sets": [
                    {"name": "x", "env": "hazbot_gym/Circle-v1", "overrides": {"tier": "radar"}}
                ]
            },
            "radar",
        ),
    ],
)
def test_bad_input_shows_before_anything_is_written(
    inline: type[InlinePool], tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    with refused(message):
        run_study(load_study(episodes=1, **change), tmp_path / "out")
    assert not (tmp_path / "out").exists()


RESTLESS = """
import pathlib
import numpy as np
SPEED = pathlib.Path(__file__).with_name("speed_of_restless.txt")
class Restless:
    def __init__(self):
        self.speed = float(SPEED.read_text())
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        if pathlib.Path("out/shards").exists() and self.speed == 1.0:
            if any(pathlib.Path("out/shards").iterdir()):
                SPEED.write_text("0.5")
        return np.full((*np.shape(observation)[:-1], 1), self.speed, np.float32), state
"""


def test_file_that_is_edited_during_a_run_ends_it_before_its_rows_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "restless_under_test.py").write_text(RESTLESS)
    speed = tmp_path / "speed_of_restless.txt"
    speed.write_text("1.0")
    study = STUDY.model_copy(update={"policies": ("restless_under_test:Restless",)})
    with refused("speed_of_restless.txt"):
        run_study(study, Path("out"), workers=1, allowed=CODE)
    assert len(list(Path("out/shards").iterdir())) == 1
    run_study(study, Path("out"), workers=1, allowed=CODE)
    speeds = pd.read_parquet("out/episodes.parquet")["mean_speed_mps"]
    assert (speeds < 0.45).all()
