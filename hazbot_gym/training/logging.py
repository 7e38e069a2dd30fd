"""Logging of a training run: TensorBoard curves and a progress bar."""

from __future__ import annotations

import contextlib
import threading
import time
from collections import Counter, deque
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import BarColumn
from stable_baselines3.common.callbacks import BaseCallback

from hazbot_gym.envs.arguments import Info
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.outcome import OUTCOME_NAMES
from hazbot_gym.task.reward import SURVEY_TERM, TERMS
from hazbot_gym.utils import terminal

LEAST_STEPS = 5_000  # decisions between two points of a curve
# Curve by key of the environments' info.
CURVES = {
    "episode/return": "r",
    "episode/length": "l",
    "episode/cost": "cost",
    "episode/time_ratio": "time_ratio",
    "episode/mean_speed_mps": "speed_mps",
    **{f"reward_terms/{name}": name for name in (*TERMS, SURVEY_TERM)},
}
# The standard curves of Stable-Baselines3, over its usual number of episodes.
USUAL_CURVES = {"rollout/ep_rew_mean": "r", "rollout/ep_len_mean": "l"}
USUAL_EPISODES = 100


@contextlib.contextmanager
def disk_errors_told_once(out: Path) -> Iterator[None]:
    """Suppress the traceback of a disk error in TensorBoard's thread; its next call raises.

    Raises:
        InvalidInput: A file of the folder ``out`` cannot be written, and the error names none.
    """
    usual = threading.excepthook

    def hook(arguments: threading.ExceptHookArgs) -> None:
        if not isinstance(arguments.exc_value, OSError):
            usual(arguments)

    threading.excepthook = hook
    try:
        yield
    except OSError as error:
        if error.filename:
            raise
        raise InvalidInput(f"out: cannot write in {str(out)!r}: {error.strerror}") from error
    finally:
        threading.excepthook = usual


class EpisodeLog(BaseCallback):
    """Logs the means over the episodes that have ended, and the share of each outcome.

    It also logs Stable-Baselines3's usual curves: over the last 100 episodes, and steps per second.
    """

    def _on_training_start(self) -> None:
        self._ended: list[Info] = []
        self._recent: deque[dict[str, float]] = deque(maxlen=USUAL_EPISODES)
        self._started_at, self._started = self.model.num_timesteps, time.perf_counter()
        self._logged_at = self.model.num_timesteps

    def _on_step(self) -> bool:
        infos = self.locals["infos"]
        ended = [infos[i] for i in np.flatnonzero(self.locals["dones"])]
        self._ended += [info for info in ended if "episode" in info]
        return True

    def _on_rollout_start(self) -> None:
        # The last update's losses are already recorded, and appear at the same step.
        if self.model.num_timesteps - self._logged_at >= LEAST_STEPS:
            self._log()

    def _on_training_end(self) -> None:
        self._log()

    def _log(self) -> None:
        episodes = [info["episode"] for info in self._ended]
        for curve, name in CURVES.items() if episodes else ():
            if name not in episodes[0]:  # a term of other environments
                continue
            self.logger.record(curve, float(np.mean([episode[name] for episode in episodes])))
        outcomes = Counter(info["outcome"] for info in self._ended)
        for name in OUTCOME_NAMES[1:] if episodes else ():
            self.logger.record(f"outcome/{name}", outcomes[name] / len(episodes))
        self._recent.extend(episodes)
        for curve, name in USUAL_CURVES.items() if self._recent else ():
            mean = float(np.mean([episode[name] for episode in self._recent]))
            self.logger.record(curve, mean)
        seconds = max(time.perf_counter() - self._started, 1e-9)
        self.logger.record("time/fps", int((self.model.num_timesteps - self._started_at) / seconds))
        self.logger.dump(self.model.num_timesteps)
        self._ended, self._logged_at = [], self.model.num_timesteps


class ProgressBar(BaseCallback):
    """Progress bar; silent without a terminal."""

    def __init__(self, console: Console, steps: int) -> None:
        super().__init__()
        columns = (
            terminal.plain_column("{task.description}"),
            BarColumn(),
            terminal.plain_column(
                "{task.completed:,.0f}/{task.total:,.0f} steps, {task.fields[rate]}"
            ),
        )
        self._bar = terminal.progress_bar(console, *columns)
        self._task = self._bar.add_task("training", total=steps, rate="")

    def _on_training_start(self) -> None:
        self._bar.start()
        self._show()

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        self._show()

    def stop(self) -> None:
        """Stop the bar."""
        self._bar.stop()

    def _show(self) -> None:
        speed = self._bar.tasks[0].speed
        rate = f"{speed:,.0f} steps/s" if speed else ""
        self._bar.update(self._task, completed=self.model.num_timesteps, rate=rate)
