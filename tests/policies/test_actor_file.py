from __future__ import annotations

import io
import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.policies.actor import Actor, Normalisation
from hazbot_gym.policies.actor_file import Trained, card, describe, read, write
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.lstm import Lstm
from hazbot_gym.task.observation import LAYOUTS
from tests.refusals import refused


def some_actor(width: int = 51, hidden: int = 64, statistics: bool = False) -> Actor:
    rng = np.random.default_rng(0)
    layers = tuple(some_layer(rng, shape) for shape in pairwise((width, hidden, hidden, 1)))
    rows = np.float32(rng.uniform(1, 2, (2, width)))
    return Actor(
        layers, "tanh", "clipped", Normalisation(*rows, 10.0, 1e-8) if statistics else None
    )


def some_layer(rng: np.random.Generator, shape: tuple[int, int]) -> Layer:
    return Layer(rng.normal(size=shape).astype(np.float32), np.ones(shape[1], np.float32))


def some_memory(width: int = 51, size: int = 8) -> Actor:
    rng = np.random.default_rng(2)
    gates, head = some_layer(rng, (width + size, 4 * size)), some_layer(rng, (size, 1))
    return Actor((head,), "tanh", "clipped", lstm=Lstm(gates))


@pytest.fixture
def trained() -> Trained:
    return describe(some_actor(), algorithm="PPO", tier="tracks", results={"return": 12.5})


def written(trained: Trained, folder: Path, name: str = "policy.npz") -> Path:
    path = folder / name
    with path.open("wb") as file:
        write(trained, file)
    return path


@pytest.mark.parametrize(
    "actor",
    [some_actor(), some_actor(statistics=True), some_memory()],
    ids=["plain", "normalised", "memory"],
)
def test_an_actor_comes_back_as_it_was_written(actor: Actor, tmp_path: Path) -> None:
    path = written(describe(actor, algorithm="PPO", tier="tracks"), tmp_path)
    found = read(path)
    observations = np.random.default_rng(1).uniform(-1, 1, (50, 51))
    assert np.array_equal(found.actor.act(observations)[0], actor.act(observations)[0])
    assert found.about["algorithm"] == "PPO"
    assert path.stat().st_size < 200_000


def test_the_file_says_what_the_actor_sees_and_reached(trained: Trained, tmp_path: Path) -> None:
    about = read(written(trained, tmp_path)).about
    assert [field["name"] for field in about["observation"]] == list(LAYOUTS["tracks"].names)
    assert set(about["observation"][0]) == {"name", "unit", "low", "high", "scale"}
    assert about["results"] == {"return": 12.5}


def test_reading_asks_numpy_for_no_pickle(tmp_path: Path) -> None:
    path = tmp_path / "evil.npz"
    np.savez(path, about=np.array([{"format": 1}], object))
    with refused("damaged"):
        read(path)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"name": "left_m"}, "entry 3 ... left_m ... range_"),
        ({"unit": "cm"}, "entry 3 ... range_ ... 0..4 cm / 4"),
        ({"high": 5.0}, "entry 3 ... range_ ... 0..5 m / 4"),
        ({"low": -1.0}, "entry 3 ... range_ ... -1..4 m / 4"),
        ({"scale": 5.0}, "entry 3 ... range_ ... 0..4 m / 5"),
    ],
)
def test_another_observation_table_is_refused_by_the_field_that_differs(
    change: dict[str, Any], complaint: str, trained: Trained, tmp_path: Path
) -> None:
    trained.about["observation"][3] |= change
    with refused(f"observation ... {complaint}"):
        read(written(trained, tmp_path))


def test_a_table_with_narrower_bounds_reads_as_before(trained: Trained, tmp_path: Path) -> None:
    trained.about["observation"][3] |= {"high": 3.0}  # with the same scale
    path = written(trained, tmp_path)
    assert read(path).actor.width == trained.actor.width


def test_a_table_of_another_length_is_refused(trained: Trained, tmp_path: Path) -> None:
    trained.about["observation"].pop()
    with refused("50 ... 51"):
        read(written(trained, tmp_path))


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"format": 99}, "99 ... 1"),
        ({"tier": "radar"}, "'radar' ... sonar, tracks, privileged"),
        ({"activation": "elu"}, "damaged"),
        ({"action": "levels"}, "damaged"),
    ],
)
def test_a_description_that_cannot_be_used_is_one_line(
    change: dict[str, Any], complaint: str, trained: Trained, tmp_path: Path
) -> None:
    trained.about.update(change)
    with refused(complaint):
        read(written(trained, tmp_path))


def test_damaged_files_are_one_line_wherever_the_damage_is(
    trained: Trained, tmp_path: Path
) -> None:
    path = written(trained, tmp_path)
    whole = path.read_bytes()
    for place in np.linspace(0, len(whole) - 1, 40).astype(int):
        path.write_bytes(whole[:place])  # cut short
        with refused("policy.npz ... damaged"):
            read(path)
    middle = len(whole) // 2  # inside a compressed array
    path.write_bytes(
        whole[:middle] + bytes(b ^ 0xFF for b in whole[middle : middle + 8]) + whole[middle + 8 :]
    )
    with refused("policy.npz ... damaged"):
        read(path)


def test_weights_that_do_not_fit_or_are_no_numbers_are_refused(tmp_path: Path) -> None:
    actor = some_actor()
    first, *others = actor.layers
    odd = Layer(np.ones((7, 1), np.float32), np.ones(1, np.float32))
    broken = first.weight.copy()
    broken[0, 0] = np.nan
    for layers in ([Layer(broken, first.bias), *others], [first, odd]):
        bad = describe(actor._replace(layers=tuple(layers)), algorithm="PPO", tier="tracks")
        with refused("damaged"):
            read(written(bad, tmp_path))


def test_a_memory_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    odd = some_memory()._replace(lstm=some_memory(width=47).lstm)
    path = written(describe(some_memory(), algorithm="RecurrentPPO", tier="tracks"), tmp_path)
    assert "51 -> LSTM of 8 -> 1" in card(read(path), "mine")
    trained = describe(some_memory(), algorithm="RecurrentPPO", tier="tracks")
    with refused("damaged"):
        read(written(trained._replace(actor=odd), tmp_path))


def test_a_missing_file_is_one_line(tmp_path: Path) -> None:
    with refused("policy ... nowhere.npz"):
        read(tmp_path / "nowhere.npz")


def test_an_actor_is_described_for_the_tier_of_its_width_only() -> None:
    with refused("sonar ... 12 ... 51"):
        describe(some_actor(), algorithm="PPO", tier="sonar")
    with refused("tier ... 'radar' ... sonar, tracks"):
        describe(some_actor(), algorithm="PPO", tier="radar")


def test_the_card_tells_how_to_use_it_and_what_it_reached(trained: Trained) -> None:
    text = card(trained, "mine")
    for part in (
        "# mine",
        "PPO",
        "51 -> 64 -> 64 -> 1",
        "learned:path=mine.npz",
        "| return | 12.5",
    ):
        assert part in text


def repacked(folder: Path, **changes: Any) -> Path:
    """Write an actor with some of its arrays exchanged, added or (None) left out."""
    actor = some_actor(hidden=4, statistics=True)
    with np.load(written(describe(actor, algorithm="PPO", tier="tracks"), folder)) as archive:
        arrays = {**archive, **changes}
    path = folder / "repacked.npz"
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    return path


@pytest.mark.parametrize(
    "array",
    [
        np.asfortranarray(np.full((51, 4), 0.5, np.float32)),
        np.full((51, 4), 0.5, ">f4"),
        np.full((51, 4), 0.5, np.float64),
    ],
    ids=["fortran", "big-endian", "double"],
)
def test_weights_in_another_order_or_precision_are_the_same_weights(
    array: Any, tmp_path: Path
) -> None:
    expected = read(repacked(tmp_path, weight0=np.full((51, 4), 0.5, np.float32))).actor
    found = read(repacked(tmp_path, weight0=array)).actor
    blank = np.full((3, 51), 0.25, np.float32)
    assert found.layers[0].weight.dtype == np.float32
    assert np.array_equal(found.act(blank)[0], expected.act(blank)[0])


@pytest.mark.parametrize(
    "changes",
    [
        {"weight0": np.zeros((51, 4), np.complex64)},
        {"weight0": np.zeros((51, 4), object)},
        {"weight0": np.zeros((51, 4), "f4,f4")},
        {"weight0": np.zeros((51, 4), "U3")},
        {"weight0": np.zeros((51, 4), np.uint8)},
        {"weight0": np.full((51, 4), np.nan, np.float32)},
        {"weight0": np.full((51, 4), 1e300)},
        {"weight0": np.zeros((51, 5), np.float32)},
        {"weight0": np.zeros((51, 0), np.float32), "bias0": np.zeros(0, np.float32)},
        {"weight0": np.zeros((4, 51), np.float32)},
        {"weight1": np.zeros((4, 0), np.float32)},
        {"bias0": np.zeros((4, 1), np.float32)},
        {"bias0": np.full(4, -np.inf, np.float32)},
        {"bias1": None},
        {"weight1": None},
        {"weight4": np.zeros((1, 1), np.float32), "bias4": np.zeros(1, np.float32)},
        {"weight_more": np.zeros((1, 1), np.float32)},
        {"mystery": np.zeros(1, np.float32)},
        {"gate_weight": np.zeros((51, 0), np.float32), "gate_bias": np.zeros(0, np.float32)},
        {"gate_bias": np.zeros(4, np.float32)},
        {"mean": None},
        {"mean": np.zeros(47, np.float32)},
        {"variance": np.full(51, -1.0, np.float32)},
        {"clip_epsilon": np.array([10.0, -1e-3])},
        {"clip_epsilon": np.array([-1.0, 1e-8])},
        {"clip_epsilon": np.array([10.0])},
        {"about": None},
        {"about": np.zeros(3, np.float32)},
        {"about": np.frombuffer(b"[1, 2]", np.uint8)},
        {"about": np.frombuffer(b"[" * 100_000, np.uint8)},
        {"about": np.frombuffer(b'{"a":' * 100_000, np.uint8)},
        {"about": np.frombuffer(b"\xff\xfe\xfd", np.uint8)},
        {"about": np.full(9_000_000, 32, np.uint8)},
    ],
    ids=lambda changes: ",".join(changes),
)
def test_arrays_that_make_no_actor_are_one_line(changes: dict[str, Any], tmp_path: Path) -> None:
    with refused("repacked.npz ... damaged"):
        read(repacked(tmp_path, **changes))


@pytest.mark.parametrize("scale", [True, "1", float("nan"), 0, 3, None])
def test_a_correction_of_no_usable_scale_is_refused(scale: Any, tmp_path: Path) -> None:
    trained = describe(some_actor(), algorithm="PPO", tier="tracks")
    about = trained.about | {"residual": {"base": "constant", "scale": scale}}
    with np.load(written(trained, tmp_path)) as archive:
        arrays = dict(archive)
    arrays["about"] = np.frombuffer(json.dumps(about).encode(), np.uint8)
    np.savez(tmp_path / "odd.npz", **arrays)
    with refused("damaged"):
        read(tmp_path / "odd.npz")


def test_a_network_that_is_too_large_to_be_read_again_is_not_written(tmp_path: Path) -> None:
    huge = some_actor()._replace(
        layers=(
            Layer(np.zeros((51, 700_000), np.float32), np.zeros(700_000, np.float32)),
            Layer(np.zeros((700_000, 1), np.float32), np.zeros(1, np.float32)),
        )
    )
    with refused("network ... 14"):
        write(describe(huge, algorithm="PPO", tier="tracks"), io.BytesIO())
