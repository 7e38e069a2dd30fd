"""A batch shows its worlds as single environments show themselves, and videos are made of it."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import gymnasium
import imageio_ffmpeg
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecVideoRecorder

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.sb3 import CorridorVecEnv
from hazbot_gym.envs.vector import CorridorVectorEnv
from tests.refusals import refused

SHORT: dict[str, Any] = {"render_mode": "rgb_array", "max_episode_steps": 8}


def actions(worlds: int, steps: int) -> Any:
    return np.random.default_rng(0).uniform(0.0, 1.0, (steps, worlds, 1))


def frames_of(envs: CorridorVectorEnv) -> list[Any]:
    assert envs._viewer is not None
    times = envs.state().time_s
    return [envs._viewer._frame(i, envs._worlds, times[i]) for i in range(envs.num_envs)]


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_every_world_shows_what_its_single_environment_shows(mode: AutoresetMode) -> None:
    envs = CorridorVectorEnv(2, autoreset_mode=mode, place="circle", **SHORT)
    singles = [CorridorEnv(place="circle", **SHORT) for _ in range(2)]
    envs.reset(seed=3)
    for i, env in enumerate(singles):
        env.reset(seed=3 + i)
    over = False
    for action in actions(2, 20):
        envs.step(action)
        for i, env in enumerate(singles):
            if over and mode == AutoresetMode.NEXT_STEP:
                env.reset()
                continue
            *_, truncated, _ = env.step(action[i])
            if truncated and mode == AutoresetMode.SAME_STEP:
                env.reset()
        over = bool(truncated) and not over
        for env, frame in zip(singles, frames_of(envs), strict=True):
            expected = env._viewer._frame
            assert expected is not None
            assert frame.outcome == expected.outcome
            assert frame.trail == pytest.approx(expected.trail, abs=1e-9)
            assert frame.terms == pytest.approx(expected.terms, abs=1e-9)
            for name in ("total_reward", "time_s", "castor_rad", "command_mps", "x_m"):
                assert getattr(frame, name) == pytest.approx(getattr(expected, name), abs=1e-9)


@pytest.mark.parametrize(
    ("changes", "height"), [({}, 544), ({"gas": {"leak_share": 1.0}}, 576)], ids=["", "gas"]
)
def test_pictures_are_those_of_single_environments(changes: dict[str, Any], height: int) -> None:
    envs, env = CorridorVectorEnv(2, **SHORT, **changes), CorridorEnv(**SHORT, **changes)
    envs.reset(seed=3), env.reset(seed=3)
    for action in actions(2, 5):
        envs.step(action), env.step(action[0])
    pictures = envs.render()
    assert isinstance(pictures, tuple)
    assert [picture.shape for picture in pictures] == [(height, 960, 3)] * 2
    assert pictures[0].dtype == np.uint8
    different = np.mean(np.any(pictures[0] != env.render(), axis=-1))
    assert different < 1e-3  # positions differ in their last bits
    assert not np.array_equal(*pictures)


def test_worlds_that_are_not_stepped_look_as_before() -> None:
    envs = CorridorVectorEnv(2, **SHORT)
    envs.reset(seed=3)
    envs.step(np.ones((2, 1)))
    before = envs.render()
    envs.step(np.ones((2, 1)), mask=np.array([True, False]))
    after = envs.render()
    assert before is not None
    assert after is not None
    assert not np.array_equal(before[0], after[0])
    assert np.array_equal(before[1], after[1])


def test_a_copy_shows_the_same() -> None:
    envs = CorridorVectorEnv(2, **SHORT)
    envs.reset(seed=3)
    envs.step(np.ones((2, 1)))
    pictures = envs.render()
    for twin in (copy.deepcopy(envs), pickle.loads(pickle.dumps(envs))):
        assert np.array_equal(twin.render(), pictures)


@pytest.mark.skipif(
    not hasattr(wrappers.vector, "RecordVideo"), reason="before 1.2.3 Gymnasium records no batches"
)
def test_gymnasium_records_all_worlds(tmp_path: Path) -> None:
    made = gymnasium.make_vec(
        "hazbot_gym/Corridor-v1", 2, vectorization_mode="vector_entry_point", **SHORT
    )
    video_of = wrappers.vector.RecordVideo
    envs = video_of(made, str(tmp_path / "video"), episode_trigger=lambda episode: episode == 0)
    envs.reset(seed=0)
    for action in actions(2, 10):
        envs.step(action)
    envs.close()
    video = str(tmp_path / "video" / "rl-video-episode-0.mp4")
    assert imageio_ffmpeg.count_frames_and_secs(video) == (9, pytest.approx(0.9))


def test_stable_baselines_records_the_first_worlds(tmp_path: Path) -> None:
    batch = CorridorVecEnv(12, seed=0, **SHORT)
    envs = VecVideoRecorder(batch, str(tmp_path), lambda step: step == 0, video_length=3)
    envs.reset()
    for action in actions(12, 4):
        envs.step(action)
    assert len(batch.get_images()) == 9
    picture = envs.render()
    assert picture is not None
    assert picture.shape == (3 * 544, 3 * 960, 3)
    envs.close()
    assert [path.suffix for path in tmp_path.iterdir()] == [".mp4"]


def test_without_a_mode_there_are_no_pictures() -> None:
    envs = CorridorVectorEnv(2)
    envs.reset(seed=0)
    assert envs.render() is None
    assert CorridorVecEnv(2).get_images() == []


def test_without_a_reset_there_is_nothing_to_show() -> None:
    with refused("render ... no episode"):
        CorridorVectorEnv(2, **SHORT).render()


@pytest.mark.parametrize("mode", ["human", "ansi", 3])
def test_a_batch_has_no_window(mode: Any) -> None:
    with refused(f"render_mode ... {mode!r} ... batch"):
        CorridorVectorEnv(2, render_mode=mode)
