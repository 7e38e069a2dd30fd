"""An environment shows itself: pictures, a window, videos by Gymnasium's own recorder."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pygame
import pytest
from gymnasium.wrappers import RecordVideo

import hazbot_gym  # noqa: F401 - registers the environments
from hazbot_gym.core.kinematics import castor_angle
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.window import Window
from tests.refusals import refused

FULL_SPEED = np.ones(1, np.float32)
QUICK: dict[str, Any] = {"clock": {"physics_s": 0.01, "social_s": 0.01, "decision_s": 0.01}}


@pytest.fixture(autouse=True)
def closed_display() -> Any:
    yield
    pygame.display.quit()


def drive(env: Any, decisions: int) -> None:
    for _ in range(decisions):
        env.step(FULL_SPEED)


def test_a_picture_is_an_array_that_changes_as_the_robot_drives() -> None:
    env = CorridorEnv(render_mode="rgb_array")
    env.reset(seed=1)
    first = env.render()
    drive(env, 20)
    second = env.render()

    assert first is not None
    assert second is not None
    assert first.dtype == np.uint8
    assert first.shape == second.shape == (544, 960, 3)
    assert not np.array_equal(first, second)


def test_without_a_reset_there_is_nothing_to_show() -> None:
    with refused("render ... no episode"):
        CorridorEnv(render_mode="rgb_array").render()


def test_what_is_shown_is_what_the_step_returned() -> None:
    env = CorridorEnv(render_mode="rgb_array", max_episode_steps=30, people={"count": [0, 0]})
    env.reset(seed=1)
    total = 0.0
    for _ in range(30):
        _, reward, _, _, info = env.step(FULL_SPEED)
        total += float(reward)

    frame = env._viewer._frame
    assert frame is not None
    assert sum(frame.terms.values()) == pytest.approx(float(reward))
    assert frame.total_reward == pytest.approx(total)
    assert frame.outcome == info["outcome"] == "timeout"
    assert frame.time_s == info["time_s"]
    assert len(frame.trail) == 31

    env.reset(seed=2)
    frame = env._viewer._frame
    assert frame is not None
    assert (frame.total_reward, frame.outcome, len(frame.trail)) == (0.0, "", 1)


def test_the_castor_trails_as_the_turn_demands() -> None:
    env = CorridorEnv(render_mode="rgb_array", place="circle", people={"count": [0, 0]})
    env.reset(seed=1)
    drive(env, 60)

    frame = env._viewer._frame
    assert frame is not None
    expected = castor_angle(3.431, env.config.drive.chassis)
    assert frame.castor_rad == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize(("decision_s", "fps"), [(0.1, 10.0), (0.05, 20.0)])
def test_the_frame_rate_is_that_of_the_decisions(decision_s: float, fps: float) -> None:
    assert CorridorEnv(clock={"decision_s": decision_s}).metadata["render_fps"] == fps
    assert CorridorEnv.metadata["render_fps"] == 10


def test_rendering_changes_nothing_that_the_policy_sees() -> None:
    results = []
    for mode in (None, "rgb_array"):
        env = CorridorEnv(render_mode=mode)
        env.reset(seed=3)
        drive(env, 30)
        env.render()
        observation, reward, *_ = env.step(FULL_SPEED)
        results.append((observation, reward))

    assert np.array_equal(results[0][0], results[1][0])
    assert results[0][1] == results[1][1]


def test_a_window_shows_every_step_by_itself() -> None:
    env = CorridorEnv(render_mode="human", **QUICK)
    env.reset(seed=1)
    surface = pygame.display.get_surface()
    assert surface is not None
    first = pygame.surfarray.array3d(surface)
    drive(env, 20)

    assert env.render() is None
    assert not np.array_equal(first, pygame.surfarray.array3d(surface))
    env.close()
    env.close()
    assert not pygame.display.get_init()


def test_the_user_closes_the_window_and_the_episode_goes_on() -> None:
    env = CorridorEnv(render_mode="human", **QUICK)
    env.reset(seed=1)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    drive(env, 3)

    assert not pygame.display.get_init()
    env.reset()
    drive(env, 1)
    assert not pygame.display.get_init()
    env.close()


@pytest.mark.parametrize("mode", ["human", "rgb_array"])
def test_a_copied_environment_shows_for_itself(mode: str) -> None:
    env = CorridorEnv(render_mode=mode, **QUICK)
    env.reset(seed=1)
    env.render()

    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        drive(other, 1)
        if mode == "rgb_array":
            assert not np.array_equal(other.render(), env.render())


def test_keys_are_reported_once() -> None:
    window = Window("keys", 1000.0)
    window.show(np.zeros((32, 48, 3), np.uint8))
    for key in (pygame.K_SPACE, pygame.K_RIGHT):
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))
    window.wait()

    assert window.pressed() == ["space", "right"]
    assert window.pressed() == []


def test_a_screenless_machine_is_told_what_helps(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> None:
        raise pygame.error("No available video device")

    env = CorridorEnv(render_mode="human")
    with monkeypatch.context() as patch:
        patch.setattr(pygame.display, "init", fail)
        with refused("--save FILE ... SDL_VIDEODRIVER=dummy"):
            env.reset(seed=1)
    monkeypatch.delenv("SDL_VIDEODRIVER")
    monkeypatch.setattr(pygame.display, "get_driver", lambda: "offscreen")
    with refused("display"):
        env.reset(seed=1)


def test_gymnasium_records_a_film(tmp_path: Path) -> None:
    env = gymnasium.make("hazbot_gym/Corridor-v1", render_mode="rgb_array", max_episode_steps=5)
    recorder = RecordVideo(env, str(tmp_path / "videos"))
    recorder.reset(seed=1)
    drive(recorder, 5)
    recorder.close()

    (video,) = (tmp_path / "videos").glob("*.mp4")
    assert video.stat().st_size > 1000
