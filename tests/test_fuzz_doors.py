"""Damaged and odd input at every door: the answer is a result, or one line and exit code 2.

Each example changes something valid a little: a value of a config file, a byte of a track file, an
option of a command. Examples are drawn with fixed seeds.
"""

from __future__ import annotations

import contextlib
import functools
import io
import json
import random
import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from hazbot_gym.cli import app
from hazbot_gym.config import make_config
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.errors import HazbotError
from hazbot_gym.policies import base
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.runtime.robot_file import Robot, check_agreement, load_robot
from hazbot_gym.study.config import load_study
from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.training.config import load_training

# Doubts are answers, too.
pytestmark = pytest.mark.filterwarnings(
    "ignore::hazbot_gym.errors.DoubtfulPlace", "ignore::hazbot_gym.errors.DoubtfulRecording"
)

CONFIGS = Path(__file__).parent.parent / "configs"

ODD_VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 7.5, 0.0, 2**31, 2**63, 2**64, 10**30),
    *(1e-9, 1e308, -1e308, float("nan"), float("inf"), float("-inf")),
    *("", " ", "yes", "5", "1e-3", "abc", "nan", "..", "../x", "/", "/dev/null", "no/such.yaml"),
    *("a b", "[/x]", "é", "日本", "\x00", "\ud800".encode("utf-8", "replace").decode(), "x" * 5000),
    *("hazbot_gym/Corridor-v1", "constant", "learned:path=e.zip,allow_pickle=true", "os:system"),
    *([], [None], [1, 2], [[0, 0], [1, 1]], ["constant"], {}, {"a": 1}, {"": {}}, {"name": "x"}),
)

CONFIG = {
    "place": "corridor",
    "place_options": {"length_m": 12.0},
    "tier": "tracks",
    "action_type": "continuous",
    "max_episode_steps": 200,
    "clock": {"physics_s": 0.01, "decision_s": 0.1},
    "drive": {"nominal_speed_mps": 0.5, "wheel_loop": "ideal", "reflex_stop_m": 0.3},
    "people": {
        "model": "scripted",
        "count": [1, 2],
        "walkers": [{"x_m": 4.0, "y_m": 0.5, "vx_mps": -0.5, "vy_mps": 0.0}],
    },
    "sensors": {
        "ring": [{"name": "ahead", "angle_rad": 0.0, "half_cone_rad": 0.2}],
        "ultrasonic": {"noise_m": 0.0},
        "tracker": {"range_m": 8.0, "latency_steps": 2},
    },
    "gas": {
        "sensor": {"rise_s": 1.0, "decay_s": 4.0, "half_ppm": 5.0, "exponent": 0.5},
        "leak_share": 1.0,
        "strength_ppm": [5.0, 50.0],
        "plume": {"meander_s": 20.0},
    },
    "reward": {"progress": 1.0},
}
STUDY = {
    "policies": ["constant:0.5", "fuzzy_expert"],
    "tuned": ["ttc"],
    "sets": [
        "E*",
        {"name": "mine", "env": "hazbot_gym/Corridor-v1", "overrides": {"tier": "sonar"}},
    ],
    "learners": [{"name": "ppo", "config": str(CONFIGS / "ppo.yaml"), "seeds": 2}],
    "fronts": {"sets": ["E*"], "families": ["ttc"], "corner": [2.0, 0.1]},
    "oracle": {"sets": ["mine"], "episodes": 2},
    "episodes": 3,
    "seed": 1,
    "ssm": {"latency_s": 0.1},
}
TRAINING = {
    "algorithm": "ppo",
    "env": ["hazbot_gym/Corridor-v1"],
    "overrides": {"people": {"count": [1, 2]}},
    "worlds": 8,
    "steps": 1000,
    "residual": {"base": "ssm", "scale": 0.5},
    "options": {"n_steps": 32, "batch_size": 64, "ent_coef": 0.001},
    "network": {"net_arch": [8, 8], "activation": "relu"},
    "validation": {"every_steps": 500, "episodes": 2},
}
PLACE = {
    "name": "my laboratory",
    "walls": [[-2, 1.2, 14, 1.2], [-2, -1.2, 14, -1.2]],
    "path": {"points": [[0, 0], [12, 0]], "corner_radius_m": 1.0},
    "routes": [{"points": [[6, -4], [6, 4]], "room_m": 0.4}],
    "along_room_m": 0.7,
}
ROBOT = {
    "nominal_speed_mps": 0.5,
    "decision_period_s": 0.1,
    "deceleration_mps2": 1.5,
    "sensors": [
        {"name": "ahead", "x_m": 0.3, "y_m": 0.0, "yaw_rad": 0.0},
        {"name": "behind", "x_m": -0.3, "y_m": 0.0, "yaw_rad": 3.1, "half_cone_rad": 0.2},
    ],
}
DESCRIPTION = {
    "fps": 10,
    "units": "m",
    "geometry": {
        "corridor_axis": "x",
        "corridor_x": [0, 10],
        "corridor_y": [-2, 2],
        "walls": [[[0, 2], [10, 2]]],
    },
    "source": {"repo": "a", "original_file": "b"},
}


def track_rows() -> Iterator[tuple[int, int, float, float]]:
    """Yield id, frame, x and y of three people who walk across."""
    for person in range(1, 4):
        for frame in range(40):
            yield person, frame, 0.1 * frame, 0.5 * person


TRACKS = {
    "juelich.txt": "\n".join(f"{i} {f} {x:.3f} {y:.3f}" for i, f, x, y in track_rows()),
    "frames_first.txt": "\n".join(f"{10 * f}\t{i}\t{x:.3f}\t{y}" for i, f, x, y in track_rows()),
    "named.csv": "id,frame,x/m,y/m\n"
    + "\n".join(f"{i},{f},{x:.3f},{y}" for i, f, x, y in track_rows()),
    "semicolons.csv": "frame;id;x;y\n"
    + "\n".join(f"{f};{i};{x:.3f};{y}".replace(".", ",") for i, f, x, y in track_rows()),
    "trajnet.ndjson": "\n".join(
        json.dumps({"track": {"f": f, "p": i, "x": x, "y": y}}) for i, f, x, y in track_rows()
    ),
    "obsmat.txt": "\n".join(
        f" {f:.7e} {i:.7e} {x:.7e} 0 {y:.7e} 1.0e+0 0 0" for i, f, x, y in track_rows()
    ),
    "annotations.txt": "\n".join(
        f'{i} {90 * x:.0f} {90 * y:.0f} {90 * x + 20:.0f} {90 * y + 20:.0f} {f} 0 0 0 "Pedestrian"'
        for i, f, x, y in track_rows()
    ),
    "times.csv": "Time [ms],Ped ID,kind,X (mm),Y (mm)\r\n"
    + "\r\n".join(f'{100 * f},P{i},"a, b",{1e3 * x:.1f},{1e3 * y}' for i, f, x, y in track_rows()),
}


@functools.cache
def sqlite_of_jupedsim() -> bytes:
    """Return the bytes of a JuPedSim database."""
    with contextlib.closing(sqlite3.connect(":memory:")) as base:
        base.execute("create table trajectory_data(frame int, id int, pos_x real, pos_y real)")
        rows = [(f, i, x, y) for i, f, x, y in track_rows()]
        base.executemany("insert into trajectory_data values(?, ?, ?, ?)", rows)
        base.execute("create table metadata(key text, value text)")
        base.execute("insert into metadata values('version', '2'), ('fps', '10')")
        base.execute("create table geometry(hash int, wkt text)")
        base.execute("insert into geometry values(1, 'POLYGON((0 0,4 0,4 2,0 2,0 0))')")
        base.commit()
        return base.serialize()


@functools.cache
def hdf5_of_juelich() -> bytes:
    """Return the bytes of an hdf5 file of the Juelich archive."""
    h5py = pytest.importorskip("h5py")
    content = io.BytesIO()
    kind = [("id", "i8"), ("frame", "i8"), ("x", "f8"), ("y", "f8")]
    with h5py.File(content, "w") as file:
        tracks = file.create_dataset("trajectory", data=np.array(list(track_rows()), dtype=kind))
        tracks.attrs["fps"] = 10.0
        file.attrs["wkt_geometry"] = "POLYGON((0 0,4 0,4 2,0 2,0 0))"
    return content.getvalue()


BINARY_TRACKS = {"jupedsim.sqlite": sqlite_of_jupedsim, "juelich.h5": hdf5_of_juelich}

Door = Callable[[Path, random.Random], object]


# --- changes -------------------------------------------------------------------------------------


def changed(tree: Any, rng: random.Random) -> Any:
    """Return a copy of nested mappings and lists with one odd value, or one key less or more."""
    tree = json.loads(json.dumps(tree))
    holder = rng.choice(list(holders(tree)))
    keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
    kind = rng.random()
    if kind < 0.1 and isinstance(holder, dict):
        holder[rng.choice(["nmae", "", "a b", "fps ", "seed"])] = rng.choice(ODD_VALUES)
    elif kind < 0.2 and keys:
        del holder[rng.choice(keys)]
    elif keys:
        holder[rng.choice(keys)] = rng.choice(ODD_VALUES)
    return tree


def holders(tree: Any) -> Iterator[Any]:
    """Yield every mapping and list in a tree."""
    yield tree
    for value in tree.values() if isinstance(tree, dict) else tree:
        if isinstance(value, dict | list):
            yield from holders(value)


def damaged(content: bytes, rng: random.Random) -> bytes:
    """Return bytes some of which are changed, removed or doubled."""
    data = bytearray(content)
    for _ in range(rng.choice([1, 1, 1, 3, 30])):
        at, length = rng.randrange(len(data)), rng.choice([1, 1, 1, 8, 200])
        action = rng.randrange(4)
        if action == 0:
            data[at : at + length] = rng.randbytes(min(length, len(data) - at))
        elif action == 1 and len(data) > length:
            del data[at : at + length]
        elif action == 2:
            data[at:at] = data[at : at + length]
        else:
            data[at:at] = rng.choice(ODD_TEXTS)
    return bytes(data)


ODD_TEXTS = (
    *(b"\n", b"\x00", b"\xff\xfe", b",", b";", b"#", b'"', b"nan", b"1e309", b"-", b":", b"\t"),
    *(b"[" * 99, b"9" * 30, b"!!int ''", b"&a [*a]", b"<<: 1", b"? ", b"{", "é".encode("latin-1")),
)


# --- doors ---------------------------------------------------------------------------------------


def config(folder: Path, rng: random.Random) -> None:
    env = CorridorEnv(changed(CONFIG, rng))
    env.reset(seed=0)
    env.step(env.action_space.sample())


def config_file(folder: Path, rng: random.Random) -> None:
    file = folder / "config.yaml"
    file.write_bytes(damaged(yaml.safe_dump(CONFIG).encode(), rng))
    make_config(file)


def study_file(folder: Path, rng: random.Random) -> None:
    file = folder / "study.yaml"
    file.write_text(yaml.safe_dump(changed(STUDY, rng)), encoding="utf-8")
    load_study(file).identity()


def damaged_study_file(folder: Path, rng: random.Random) -> None:
    file = folder / "study.yaml"
    file.write_bytes(damaged((CONFIGS / "study_bank.yaml").read_bytes(), rng))
    load_study(file).identity()


def training_file(folder: Path, rng: random.Random) -> None:
    file = folder / "training.yaml"
    file.write_text(yaml.safe_dump(changed(TRAINING, rng)), encoding="utf-8")
    load_training(file).environments()


def damaged_training_file(folder: Path, rng: random.Random) -> None:
    file = folder / "training.yaml"
    file.write_bytes(damaged((CONFIGS / "ppo_residual.yaml").read_bytes(), rng))
    load_training(file).environments()


def place_file(folder: Path, rng: random.Random) -> None:
    file = folder / "place.yaml"
    text = yaml.safe_dump(changed(PLACE, rng)).encode()
    file.write_bytes(text if rng.random() < 0.7 else damaged(text, rng))
    env = CorridorEnv(place=str(file), people={"count": [1, 1]})
    env.reset(seed=0)


def robot_file(folder: Path, rng: random.Random) -> None:
    file = folder / "robot.yaml"
    text = yaml.safe_dump(changed(ROBOT, rng)).encode()
    file.write_bytes(text if rng.random() < 0.7 else damaged(text, rng))
    check_agreement(load_robot(file), Robot(), "constant")


def track_file(folder: Path, rng: random.Random) -> None:
    name = rng.choice(list(TRACKS))
    (folder / name).write_bytes(damaged(TRACKS[name].encode(), rng))
    (folder / name).with_suffix(".json").write_text(json.dumps(DESCRIPTION))
    read_tracks(folder / name)


def binary_track_file(folder: Path, rng: random.Random) -> None:
    name = rng.choice(list(BINARY_TRACKS))
    (folder / name).write_bytes(damaged(BINARY_TRACKS[name](), rng))
    read_tracks(folder / name)


def track_description(folder: Path, rng: random.Random) -> None:
    (folder / "named.csv").write_text(TRACKS["named.csv"])
    text = json.dumps(changed(DESCRIPTION, rng)).encode()
    (folder / "named.json").write_bytes(text if rng.random() < 0.7 else damaged(text, rng))
    read_tracks(folder / "named.csv")


def policy_file(folder: Path, rng: random.Random) -> None:
    file = folder / "policy.npz"
    file.write_bytes(damaged(rng.choice(sorted(SHIPPED.glob("*.npz"))).read_bytes(), rng))
    base.make(f"learned:path={file}")


def policy_name(folder: Path, rng: random.Random) -> None:
    name = rng.choice([*base.REGISTER, "", "os", "no_such_module", "a.b"])
    options = rng.choice(["", ":", ":x", ":path=", ":=", ":,", ":a=1,a=2", ":{}", ":stop_m={}"])
    base.make(name + options.format(rng.choice(ODD_VALUES)))


DOORS: dict[Door, int] = {
    config: 120,
    config_file: 120,
    study_file: 120,
    damaged_study_file: 80,
    training_file: 120,
    damaged_training_file: 80,
    place_file: 120,
    robot_file: 150,
    track_file: 250,
    binary_track_file: 100,
    track_description: 120,
    policy_file: 120,
    policy_name: 150,
}


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.__name__)
def test_door_gives_a_result_or_one_line(door: Door, tmp_path: Path) -> None:
    faults = []
    for seed in range(DOORS[door]):
        folder = tmp_path / str(seed)
        folder.mkdir()
        try:
            door(folder, random.Random(f"{door.__name__} {seed}"))
        except HazbotError as error:
            if not is_one_line(str(error)):
                faults.append(f"{seed}: not one line: {str(error)!r}")
        except Exception as error:
            faults.append(f"{seed}: {type(error).__name__}: {str(error)[:200]}")
    assert faults == []


def is_one_line(text: str) -> bool:
    return len(text.splitlines()) == 1


# --- the command line ----------------------------------------------------------------------------

ODD_WORDS = (
    *("", " ", "-1", "0", "1", "abc", "7.5", "1e9", "nan", "[20]", "yes", str(2**63), str(10**30)),
    *("constant", "constant:2", "learned:x.npz", "learned:x.zip", ":x", "x:", "E*", "[/x]"),
    *("é\x01", "no/such.yaml", "folder", "/dev/null/x", "broken.yaml", "tier=", "=1", "a=[4,4]"),
)
# Each lacks something, or is over in a moment.
COMMANDS: dict[str, tuple[str, ...]] = {
    "eval --episodes 1 --policy": ("--seed", "--scenario", "--set", "--engine", "--env"),
    "watch --save no/such.gif --policy": ("--episodes", "--seed", "--set", "--speed", "--at"),
    "study --config no/such.yaml --out": ("--episodes", "--workers", "--seed", "--engine"),
    "study --config": ("--episodes", "--workers", "--seed", "--tracks"),
    "train --config broken.yaml --out": ("--seed", "--steps", "--engine", "--resume"),
    "train --steps 0 --config": ("--seed", "--out", "--engine"),
    "report": (),
    "tracks": (),
    "calibrate --tracks": ("--fit", "--seed", "--json"),
    "calibrate --ratings": ("--fit", "--seed", "--json"),
    "headroom --env nowhere --json": ("--episodes",),
    "tune --trials 1 --out no/such/x.json --policy": ("--seed",),
    "bench --training": ("--json",),
    "export --format c --out /dev/null/x --policy": ("--tier",),
    "export --policy constant --out /dev/null/x --format": ("--tier",),
}
FLAGS = ("--resume",)


@pytest.mark.parametrize("command", COMMANDS)
def test_command_ends_with_a_result_or_one_line(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("broken.yaml").write_text("a: [1, 2")
    Path("folder").mkdir()
    rng, faults = random.Random(command), []
    for _ in range(25):
        words = [*command.split(), rng.choice(ODD_WORDS)]
        for option in rng.sample(COMMANDS[command], min(2, len(COMMANDS[command]))):
            words += (
                [option] if option in ("--json", "--resume") else [option, rng.choice(ODD_WORDS)]
            )
        faults += [f"{words}: {fault}" for fault in faults_of(words)]
    assert faults == []
    assert {path.name for path in tmp_path.rglob("*")} == {"broken.yaml", "folder"}


def faults_of(words: list[str]) -> Iterator[str]:
    """Yield what is wrong about how a command ended."""
    result = CliRunner().invoke(app, words)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        yield f"{type(result.exception).__name__}: {str(result.exception)[:200]}"
    elif result.exit_code not in (0, 2):
        yield f"exit code {result.exit_code}"
    elif result.exit_code == 2 and not is_one_line(result.stderr.removesuffix("\n")):
        yield f"not one line: {result.stderr!r}"
