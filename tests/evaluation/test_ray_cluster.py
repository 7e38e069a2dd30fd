"""A real Ray cluster of three nodes on this machine, which lose workers, a node, and the driver."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml

ray = pytest.importorskip("ray", reason="needs the cluster extra: make cluster")

from ray.cluster_utils import Cluster  # noqa: E402

from hazbot_gym.evaluation import mirrored_folder  # noqa: E402
from hazbot_gym.evaluation.workers import Place  # noqa: E402
from hazbot_gym.policies import actor_file  # noqa: E402
from hazbot_gym.study import store  # noqa: E402
from hazbot_gym.training.config import load_training  # noqa: E402
from tests.refusals import refused  # noqa: E402

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore:::ray")]

TRAINING = {
    "env": "hazbot_gym/Crossing-v1",
    "worlds": 4,
    "steps": 512,
    "overrides": {"max_episode_steps": 20},
    "options": {"n_steps": 16, "batch_size": 32, "n_epochs": 1},
    "network": {"net_arch": [4]},
    "validation": {"every_steps": 128, "episodes": 1},
}
STUDY = {
    "policies": ["constant:1.0", "mine:Crawl"],
    "tuned": ["constant"],
    "trials": 3,
    "trial_episodes": 1,
    "learners": [{"name": "tiny ppo", "config": "tiny.yaml", "seeds": 2}],
    "sets": [{"name": "lab", "env": "Corridor-v1", "overrides": {"place": "lab.yaml"}}],
    "episodes": 24,
    "episodes_per_shard": 2,
    "resamples": 200,
}
LAB = {
    "name": "laboratory",
    "walls": [[-2, 1.2, 14, 1.2], [-2, -1.2, 14, -1.2]],
    "path": {"points": [[0, 0], [12, 0]], "corner_radius_m": 1.0},
    "routes": [],
    "along_room_m": 0.7,
}
MINE = """
import numpy as np


class Crawl:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full((*observation.shape[:-1], 1), -0.5, np.float32), state
"""
RESULTS = (store.SUMMARY, store.EPISODES, "tuned/constant.json")


class Nodes:
    """Three nodes of one core each; the head's is where the driver is."""

    def __init__(self) -> None:
        os.environ |= {"RAY_USAGE_STATS_ENABLED": "0", "RAY_worker_niceness": "0"}
        os.environ |= {"RAY_raylet_start_wait_time_s": "300"}  # slow machines take minutes
        self._size: dict[str, int] = {"num_cpus": 1, "object_store_memory": 100_000_000}
        self.cluster = Cluster(initialize_head=True, head_node_args=self._size)
        self.others = [self.cluster.add_node(**self._size) for _ in range(2)]

    @property
    def address(self) -> str:
        return str(self.cluster.address)

    @property
    def count(self) -> int:
        return len(self.cluster.list_all_nodes())

    def kill_one(self) -> None:
        self.cluster.remove_node(self.others.pop(), allow_graceful=False)


@pytest.fixture(scope="module")
def nodes() -> Iterator[Nodes]:
    found = Nodes()
    yield found
    found.cluster.shutdown()


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a study, and all the files that it reads."""
    monkeypatch.chdir(tmp_path)
    for name, content in (("tiny", TRAINING), ("study", STUDY), ("lab", LAB)):
        Path(f"{name}.yaml").write_text(yaml.safe_dump(content))
    Path("mine.py").write_text(MINE)
    return tmp_path


def command(out: str, *options: str) -> list[str]:
    study = ["study", "--config", "study.yaml", "--out", out, "--allow-code", "--no-report"]
    return [sys.executable, "-m", "hazbot_gym", *study, *options]


def wait_for(process: subprocess.Popen[bytes], happened: Callable[[], bool]) -> None:
    while not happened():
        assert process.poll() is None, "it ended before"
        time.sleep(0.02)


def kill_at(process: subprocess.Popen[bytes], happened: Callable[[], bool]) -> None:
    wait_for(process, happened)
    process.kill()
    process.wait()


def die_once(folder: Path) -> int:
    """Kill the worker, after a file was sent; the next worker finds it."""
    attempts = folder / "attempts"
    count = int(attempts.read_text()) if attempts.exists() else 0
    folder.mkdir(exist_ok=True)
    attempts.write_text(str(count + 1))
    if not count:
        time.sleep(2 * mirrored_folder.SEND_EVERY_S)
        os.kill(os.getpid(), signal.SIGKILL)
    return count


def shards(out: Path) -> list[Path]:
    return list((out / store.SHARDS).glob("[!.]*.parquet"))


def test_a_study_whose_driver_and_a_node_are_killed_ends_with_the_same_bytes(
    nodes: Nodes, project: Path
) -> None:
    subprocess.run(command("here"), check=True)
    out = project / "there"
    print("a cluster of", nodes.count, "nodes")

    with subprocess.Popen(command("there", "--cluster", nodes.address)) as driver:
        kill_at(driver, (out / "trained/tiny_ppo/1/policy.npz").exists)
    print("the driver was killed while it trained")

    with subprocess.Popen(command("there", "--cluster", nodes.address)) as driver:
        kill_at(driver, lambda: len(shards(out)) >= 3)
    print("the driver was killed after", len(shards(out)), "of 60 shards")
    assert not (out / store.SUMMARY).exists()

    before = len(shards(out))
    with subprocess.Popen(command("there", "--cluster", nodes.address)) as driver:
        wait_for(driver, lambda: len(shards(out)) > before)
        nodes.kill_one()
        print("a node was killed after", len(shards(out)), "shards;", nodes.count, "are left")
    assert driver.returncode == 0
    for name in RESULTS:
        assert (out / name).read_bytes() == (project / "here" / name).read_bytes()
        print("equal bytes:", name)
    for seed in ("0", "1"):
        one, other = (
            actor_file.read(project / place / "trained/tiny_ppo" / seed / "policy.npz").actor
            for place in ("here", "there")
        )
        assert pickle.dumps(one) == pickle.dumps(other)
        print("equal weights: training seed", seed)


def test_a_killed_worker_is_replaced_and_finds_what_it_had_written(
    nodes: Nodes, project: Path
) -> None:
    ray.cloudpickle.register_pickle_by_value(sys.modules[__name__])  # workers have no tests
    with Place(1, nodes.address).pool() as pool:
        assert pool.submit_in(project / "run", die_once).result(120) == 1
    assert (project / "run" / "attempts").read_text() == "2"


def test_an_error_of_a_worker_is_raised_here(nodes: Nodes, project: Path) -> None:
    with refused("missing.yaml"), Place(1, nodes.address).pool() as pool:
        pool.submit(load_training, "missing.yaml").result(120)


@pytest.mark.parametrize(
    ("address", "named"), [("ray://127.0.0.1:10001", "auto"), ("somewhere", "no connection")]
)
def test_an_address_without_a_cluster_is_refused(address: str, named: str) -> None:
    with refused(named), Place(1, address).pool():
        pass


def test_the_example_of_a_cloud_cluster_is_valid() -> None:
    from ray.autoscaler._private.util import prepare_config, validate_config

    file = Path(__file__).parents[2] / "examples" / "ray_cluster.yaml"
    validate_config(prepare_config(yaml.safe_load(file.read_text())))
