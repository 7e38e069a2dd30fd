from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

import hazbot_gym
from hazbot_gym.cli import app
from hazbot_gym.evaluation.metrics import GAS_HEADLINE
from tests.refusals import says

METRICS = {
    *("delay_s", "personal_m", "intimate_m", "person_delay_s", "contacts_per_km"),
    *("discomfort_s", "contact_person_caused", "arrived", "return"),
}


@pytest.fixture(autouse=True)
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "working_folder"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def hazbot(*arguments: str) -> Result:
    return CliRunner().invoke(app, arguments)


def python(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ("study --config missing.yaml", "missing.yaml"),
        ("study --episodes 0", "episodes"),
        ("study --seed -1", "seed"),
        ("study --engine steam", "engine"),
        ("study --workers 0", "workers"),
        ("study --tracks /no/such/folder", "/no/such/folder"),
        ("study --episodes many", "--episodes"),
        ("study --epsiodes 3", "--epsiodes"),
        ("eval", "--policy"),
        ("eval --policy telepathy", "telepathy"),
        ("eval --policy constant:2", "fraction"),
        ("eval --policy constant:speed=0.5", "speed"),
        ("eval --policy no_such_module:Policy", "no_such_module"),
        ("eval --policy constant --env CartPole-v1", "CartPole-v1"),
        ("eval --policy constant --env hazbot_gym/Nowhere-v1", "Nowhere"),
        ("eval --policy constant --scenario E9", "E9"),
        ("eval --policy constant --episodes 0", "episodes"),
        ("eval --policy constant --seed -1", "seed"),
        ("eval --policy constant --engine steam", "engine"),
        ("eval --policy constant --set tier=radar", "radar"),
        ("eval --policy constant --set people.cuont=3", "cuont"),
        ("eval --policy constant --set tier", "tier"),
        ("eval --policy constant --set place=nowhere", "nowhere"),
        ("eval --policy constant --env hazbot_gym/Replay-v1 --set tracks=/no/such", "/no/such"),
        ("eval --policy learned:nowhere.npz", "nowhere.npz"),
        ("eval --policy learned:nowhere.zip", "--allow-pickle"),
        ("eval --policy learned:nowhere.zip --allow-pickle", "Stable-Baselines3"),
        ("train --config missing.yaml", "missing.yaml"),
        ("train --seed -1", "seed"),
        ("train --steps 0", "steps"),
        ("train --engine steam", "engine"),
        ("train --spets 3", "--spets"),
        ("watch", "--policy"),
        ("play --env Replay-v1", "env: given 'Replay-v1'"),
        ("play --link place=x", "place"),
        ("play --policy telepathy --port 0", "telepathy"),
        ("play --port 65536", "port"),
        ("watch --policy telepathy", "telepathy"),
        ("watch --policy constant --speed 0", "speed"),
        ("watch --policy constant --at 3", "--save"),
        ("watch --policy constant --save video.avi", ".mp4, .gif, .png"),
        ("watch --policy constant --save video.mp4 --at 3", "at"),
        ("watch --policy constant --save video.gif --scenario E9", "E9"),
        ("export", "--policy"),
        ("export --policy telepathy --format c --out there", "telepathy"),
        ("export --policy constant --format rust --out there", "rust ... onnx"),
        ("export --policy mpc --format c --out there", "mpc"),
        ("export --policy constant --format c --out /proc/x", "/proc/x"),
        ("paper --workers 0", "workers"),
        ("paper --out /dev/null", "/dev/null"),
        ("tune", "--policy"),
        ("tune --policy telepathy", "telepathy"),
        ("tune --policy ttc --trials 0", "trials"),
        ("tune --policy ttc --config configs/search/ppo.yaml", "either --policy or --config"),
        ("tune --config configs/search/nowhere.yaml", "nowhere.yaml"),
        ("tracks /no/such/folder", "/no/such/folder"),
        ("tracks nope.csv", "nope.csv"),
        ("tracks . --fps 0", "fps"),
        ("tracks . --units km", "units"),
        ("tracks . --metres-per-pixel nan", "metres_per_pixel"),
        ("report /no/such/folder", "/no/such/folder"),
        ("bench --json no/such/folder/bench.json", "bench.json"),
        ("bench --json .", "folder"),
        ("bench --latency --training run.yaml", "latency ... training"),
        ("bench --latency --export", "export ... latency"),
        ("bench --json /proc/bench.json", "/proc/bench.json"),
        ("headroom --episodes 1000000000000", "--episodes"),
        ("tune --policy ttc --out .", "folder"),
        ("tune --policy ttc --out /proc/x.json", "/proc/x.json"),
        ("paper --out /proc/x", "/proc/x"),
        ("study --out /proc/x", "/proc/x"),
        ("eval --policy constant --episodes 1000000000000000000000", "episodes"),
        ("eval --policy constant --scenario E* --set scenario=C*", "scenario"),
        ("eval --policy constant --set tier=sonar --set tier=tracks", "tier"),
        ("eval --policy constant --set people.count=3 --set people={}", "people"),
        ("watch --policy constant --save x.png --at -1", "at"),
        ("watch --policy constant --save x.png --at nan", "at"),
        ("watch --policy constant --save x.mp4 --speed 1e300", "speed"),
        ("watch --policy constant --episodes 1000000000000000000000", "episodes"),
        *((f"eval --{option}=", option) for option in ("policy", "env", "scenario")),
        ("list --bogus", "--bogus"),
        ("--bogus", "--bogus"),
        ("frobnicate", "frobnicate"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(
    arguments: str, named: str, empty_folder: Path
) -> None:
    result = hazbot(*arguments.split())
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    says(result.stderr, f"hazbot: ... {named}")
    assert list(empty_folder.iterdir()) == []


def test_an_unusable_folder_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", "there\x1b[31m")

    monkeypatch.setattr("hazbot_gym.study.catalogue.tables", refuse)
    result = hazbot("list")
    assert result.exit_code == 2
    says(result.stderr, "'there\\x1b[31m' ... Permission denied")


def test_our_own_mistakes_are_loud(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> None:
        raise FileNotFoundError(errno.ENOENT, "No such file", "ours")

    monkeypatch.setattr("hazbot_gym.study.catalogue.tables", fail)
    assert isinstance(hazbot("list").exception, FileNotFoundError)


def test_the_version_is_told() -> None:
    result = hazbot("--version")
    assert (result.exit_code, result.stdout) == (0, f"hazbot {hazbot_gym.__version__}\n")


def test_a_pipe_that_ends_early_is_quiet() -> None:
    command = f"{sys.executable} -m hazbot_gym list | head -1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert len(done.stdout.splitlines()) == 1
    assert done.stderr == ""


def test_a_foreign_output_folder_is_left_alone(empty_folder: Path) -> None:
    (empty_folder / "thesis.tex").write_text("precious")
    result = hazbot("study", "--out", ".")
    assert result.exit_code == 2
    says(result.stderr, "hazbot: out")
    assert [path.name for path in empty_folder.iterdir()] == ["thesis.tex"]


def test_eval_prints_json_and_nothing_else(empty_folder: Path) -> None:
    options = "--env hazbot_gym/Crossing-v1 --episodes 2 --seed 3 --json"
    result = hazbot("eval", "--policy", "constant:0.5", *options.split())
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert list(found) == ["policy", "env", "episodes", "seed", "metrics"]
    assert (found["policy"], found["episodes"], found["seed"]) == ("constant:0.5", 2, 3)
    assert found["env"] == "hazbot_gym/Crossing-v1"
    assert set(found["metrics"]) == METRICS
    assert all(isinstance(value, float) for value in found["metrics"].values())
    assert list(empty_folder.iterdir()) == []


def test_eval_reports_leaks_where_there_is_gas() -> None:
    arguments = ("eval", "--policy", "constant:1", "--env", "InspectionEmpty-v1", "--episodes", "6")
    found = json.loads(hazbot(*arguments, "--json").stdout)["metrics"]
    assert set(found) == METRICS | set(GAS_HEADLINE)
    assert 0.0 <= found["leak_found"] <= 1.0
    assert "false" in hazbot(*arguments).stdout


def test_watch_saves_a_picture_and_says_how_the_episode_went(empty_folder: Path) -> None:
    result = hazbot(*["watch", "--policy", "constant:1", "--scenario", "E*", "--save", "end.png"])
    assert result.exit_code == 0, result.output
    assert "arrived" in result.stdout
    assert "personal_m" in result.stdout
    assert "end.png" in result.stdout
    assert [path.name for path in empty_folder.iterdir()] == ["end.png"]


def test_eval_says_the_same_twice() -> None:
    arguments = ["eval", "--policy", "constant", "--scenario", "C*", "--episodes", "1", "--json"]
    assert hazbot(*arguments).stdout == hazbot(*arguments).stdout


def test_eval_gives_the_same_numbers_with_either_engine() -> None:
    options = ("--scenario", "E*", "--episodes", "2", "--json")
    arguments = ("eval", "--policy", "fuzzy_expert", *options)
    batched, reference = (
        json.loads(hazbot(*arguments, "--engine", engine).stdout)
        for engine in ("batched", "pymunk")
    )
    assert batched["metrics"] == pytest.approx(reference["metrics"], abs=1e-6)


def test_eval_shows_a_table_for_people() -> None:
    options = ("--episodes", "1", "--set", "people.count=[0, 0]")
    result = hazbot("eval", "--policy", "constant", *options)
    assert result.exit_code == 0, result.output
    assert "hazbot_gym/Corridor-v1" in result.stdout


def test_list_shows_environments_scenarios_the_bank_and_policies() -> None:
    result = hazbot("list")
    assert result.exit_code == 0
    names = ("hazbot_gym/Corridor-v1", "hazbot_gym/Replay-v1", "E5.5", "bank:ood/dense", "ssm")
    for shown in (*names, "(2.750, 4.763) m"):
        assert shown in result.stdout


def test_study_writes_its_files_and_shows_a_table(empty_folder: Path) -> None:
    (empty_folder / "tiny.yaml").write_text(
        "policies: ['constant:1.0']\nsets: [E*]\nresamples: 100\n"
    )
    arguments = ["study", "--config", "tiny.yaml", "--episodes", "1", "--workers", "1"]
    result = hazbot(*arguments, "--no-report")
    assert result.exit_code == 0, result.output
    assert "E*" in result.stdout
    folder = empty_folder / "results" / "study"
    written = {path.name for path in folder.iterdir()}
    records = {"manifest.json", "summary.json", "costs.json"}
    assert written == records | {"shards", "episodes.parquet", "replays.parquet"}

    assert hazbot(*arguments).exit_code == 0
    page = (folder / "report.html").read_bytes()
    (folder / "report.html").unlink()
    result = hazbot("report", str(folder))
    assert result.exit_code == 0, result.output
    assert str(folder / "report.html") in result.stdout
    assert (folder / "report.html").read_bytes() == page


def test_names_with_brackets_and_letters_of_other_scripts_go_through_a_study(
    empty_folder: Path,
) -> None:
    (empty_folder / "tiny.yaml").write_text(
        "policies: ['constant:1.0', 'constant:0.5']\nepisodes: 1\nresamples: 100\nsets:\n"
        "- {name: '[/x]', env: hazbot_gym/Corridor-v1, overrides: {people: {count: [0, 0]}}}\n"
        "- {name: '火 [bold]', env: hazbot_gym/Crossing-v1}\n"
    )
    arguments = ["study", "--config", "tiny.yaml", "--verbose", "--workers", "1"]
    done = subprocess.run(
        [sys.executable, "-m", "hazbot_gym", *arguments, "--out", "o[/x]\udcff"],
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert done.returncode == 0, done.stderr
    for text in (b"[/x]: ", b"? [bold]: ", b"o[/x]?/report.html"):
        assert text in done.stdout
    assert (empty_folder / "o[/x]\udcff" / "report.html").exists()


def test_the_report_is_written_before_anything_is_printed(
    empty_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (empty_folder / "tiny.yaml").write_text("policies: [constant]\nsets: [E*]\nresamples: 100\n")

    def fail(*_: object, **__: object) -> None:
        raise BrokenPipeError

    monkeypatch.setattr("hazbot_gym.study.terminal_tables.study_tables", fail)
    arguments = ["study", "--config", "tiny.yaml", "--episodes", "1", "--workers", "1"]
    assert hazbot(*arguments).exit_code != 0
    assert (empty_folder / "results" / "study" / "report.html").exists()


def test_train_writes_its_run_and_goes_on_with_it_only_if_asked(empty_folder: Path) -> None:
    (empty_folder / "tiny.yaml").write_text(
        "worlds: 4\noptions: {n_steps: 16, batch_size: 32}\nvalidation: {episodes: 1}\n"
    )
    command = ["train", "--config", "tiny.yaml", "--steps", "64"]
    result = hazbot(*command)
    assert result.exit_code == 0, result.output
    folder = Path("results", "train", "tiny")
    assert str(folder / "policy.npz") in result.stdout
    again, resumed, other = (
        hazbot(*command, *more) for more in ([], ["--resume"], ["--resume", "--seed", "1"])
    )
    assert (again.exit_code, resumed.exit_code, other.exit_code) == (2, 0, 2)
    says(again.stderr, "hazbot: out ... results/train/tiny ... --resume")
    says(other.stderr, "hazbot: out ... results/train/tiny")
    assert "step 64" in resumed.stderr
    policy = f"learned:{folder / 'policy.npz'}"
    evaluated = hazbot("eval", "--policy", policy, "--episodes", "1", "--json")
    assert evaluated.exit_code == 0, evaluated.output


@pytest.mark.parametrize("missing", ["torch", "stable_baselines3", "sb3_contrib", "tensorboard"])
def test_training_without_the_extra_names_it(missing: str, empty_folder: Path) -> None:
    command = (
        f"import sys; sys.modules['{missing}'] = None\n"
        "sys.argv = ['hazbot', 'train']\n"
        "import hazbot_gym.cli; hazbot_gym.cli.main()\n"
    )
    done = python("-c", command)
    assert done.returncode == 2, done.stderr
    says(done.stderr, "pip install 'hazbot-gym[train]'")
    assert list(empty_folder.iterdir()) == []


def test_help_is_quick_and_loads_nothing_heavy() -> None:
    command = (
        "import sys; sys.argv = ['hazbot', '--help']\n"
        "import hazbot_gym.cli\n"
        "try: hazbot_gym.cli.main()\n"
        "except SystemExit as end: assert end.code == 0\n"
        "heavy = {'numba', 'pymunk', 'pandas', 'pyarrow', 'torch', 'plotly', 'jinja2'}\n"
        "assert heavy.isdisjoint(sys.modules)\n"
    )
    done = python("-c", command)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("arguments", "code"),
    [("study --episodes 1", 2), ("eval --policy constant --scenario E* --episodes 1", 0)],
)
def test_only_the_study_needs_the_study_extra(
    arguments: str, code: int, empty_folder: Path
) -> None:
    command = (
        "import sys; sys.modules.update(pandas=None, pyarrow=None)\n"
        f"sys.argv = ['hazbot', *{arguments.split()}]\n"
        "import hazbot_gym.cli; hazbot_gym.cli.main()\n"
    )
    done = python("-c", command)
    assert done.returncode == code, done.stderr
    if code:
        says(done.stderr, "hazbot: pandas ... pip install 'hazbot-gym[study]'")
        assert list(empty_folder.iterdir()) == []


def test_the_package_runs_as_a_module_and_finds_policies_beside_it(empty_folder: Path) -> None:
    (empty_folder / "mine.py").write_text(
        "import numpy as np\n"
        "class Mine:\n"
        "    def predict(self, observation, state=None, episode_start=None, deterministic=True):\n"
        "        return np.full((*np.shape(observation)[:-1], 1), 1.0, np.float32), state\n"
    )
    arguments = ["eval", "--policy", "mine:Mine", "--scenario", "E*", "--episodes", "1", "--json"]
    done = python("-m", "hazbot_gym", *arguments)
    assert json.loads(done.stdout)["metrics"]["delay_s"] > 0


def test_without_stdout_and_stderr_commands_run() -> None:
    code = "import sys; sys.stdout = sys.stderr = None; from hazbot_gym.cli import main; main()"
    done = python("-c", code, "list")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
