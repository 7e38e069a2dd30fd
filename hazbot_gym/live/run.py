"""One robot in one scenario, stepped decision by decision on the reference engine, and recorded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, Protocol

import numpy as np

from hazbot_gym.config.section import Section
from hazbot_gym.envs.arguments import Info
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.evaluation.actions import ask, playable
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.evaluation.rollout import episode_of, episode_seed, resolve
from hazbot_gym.live.settings import Settings
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Actions, Observations
from hazbot_gym.sim.intervention import Intervention
from hazbot_gym.sim.world import Snapshot
from hazbot_gym.task.action import speed_action
from hazbot_gym.task.reward import weights_of

# --- what people of the scene are made to do ------------------------------------------------------


class Lead(Section):
    """A person walks towards a point during one decision."""

    edit: Literal["lead"] = "lead"
    person: int
    x_m: float
    y_m: float


class Add(Section):
    """A person enters at a point."""

    edit: Literal["add"] = "add"
    x_m: float
    y_m: float


class Remove(Section):
    """A person leaves for good."""

    edit: Literal["remove"] = "remove"
    person: int


Edit = Lead | Add | Remove

# --- who drives -----------------------------------------------------------------------------------


class Driver(Protocol):
    """Chooses the action of each decision."""

    def action(self, observation: Observations) -> Actions:
        """Return the action (1,) for an observation (n,)."""


class Hand:
    """A person at the page.

    Attributes:
        share: The commanded share of the nominal speed, in [0, 1].
    """

    share = 0.0

    def action(self, observation: Observations) -> Actions:
        """Return the commanded speed as an action."""
        return speed_action(self.share)


class PolicyDriver:
    """A policy from the start of an episode on, or from the middle of one."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy
        self._state: object = None
        self._starts = np.array([True])

    def action(self, observation: Observations) -> Actions:
        """Return the policy's action."""
        action, self._state = ask(self._policy, observation, self._state, self._starts)
        self._starts = np.array([False])
        return np.asarray(action)


class Recorded:
    """Recorded actions (T,), in order; a stop after the last."""

    def __init__(self, actions: Sequence[float]) -> None:
        self._actions = iter(actions)

    def action(self, observation: Observations) -> Actions:
        """Return the next action, in double precision: as recorded, to the last bit."""
        return np.array([next(self._actions, -1.0)])


# --- the run --------------------------------------------------------------------------------------


class Run:
    """An episode that goes on decision by decision.

    Attributes:
        env: The environment.
        driver: Who drives.
        observation: The present observation.
        info: Info of the last decision, or of the reset.
        actions: All actions so far.
        weights: (terms,) weights of the reward terms.
        totals: (terms,) weighted reward terms, summed so far.
    """

    def __init__(self, settings: Settings, driver: Driver) -> None:
        """Start the episode.

        Raises:
            InvalidInput: The settings fit no environment, such as a place too narrow for its door.
        """
        scenarios = settings.scenarios()
        self.env, self.driver = CorridorEnv(resolve(scenarios)[0]), driver
        seed = episode_seed(settings.seed, scenarios.name, settings.episode)
        self.observation, self.info = self.env.reset(seed=seed)
        self._start, self._snapshots = self.info, [self.env.snapshot()]
        self._steps: list[tuple[float, Info]] = []
        self._hand = Intervention(self.env.world)
        self.actions: list[float] = []
        self.weights = weights_of(self.env.config)
        self.totals = np.zeros(len(self.weights))
        self.is_over = self.is_edited = False

    @property
    def now(self) -> Snapshot:
        """The present true state."""
        return self._snapshots[-1]

    @property
    def snapshots(self) -> Sequence[Snapshot]:
        """All instants so far."""
        return self._snapshots

    @property
    def decision(self) -> int:
        """Number of decisions so far."""
        return len(self._steps)

    @property
    def led(self) -> tuple[int, ...]:
        """People who are led now."""
        return self._hand.led

    def step(self, edits: Sequence[Edit] = ()) -> None:
        """Take one decision, after some changes of the people."""
        if self.is_over:
            return
        self._edit(edits)
        action: Any = self.driver.action(self.observation)
        self.observation, reward, terminated, truncated, self.info = self.env.step(
            playable(action, self.env.action_space)
        )
        self.actions.append(float(action[0]))
        self._steps.append((float(reward), self.info))
        self._snapshots.append(self.env.snapshot())
        self.totals += self.weights * np.array([*self.info["reward_terms"].values()])
        self.is_over = terminated or truncated

    def newcomer_has_room(self, x_m: float, y_m: float) -> bool:
        """Return True if a person can be added at a point."""
        return self._hand.newcomer(x_m, y_m) is not None

    def episode(self) -> Episode:
        """Return the record so far; an episode that is not over counts as a timeout."""
        return episode_of(
            self.env, self._snapshots, self._steps, self._start, is_edited=self.is_edited
        )

    def _edit(self, edits: Sequence[Edit]) -> None:
        leads = {edit.person: edit for edit in edits if isinstance(edit, Lead)}
        for person in set(self._hand.led) - leads.keys():
            self._hand.release(person)
        for edit in edits:
            self.is_edited = True
            if isinstance(edit, Remove):
                self._hand.remove(edit.person)
            elif isinstance(edit, Add):
                newcomer = self._hand.newcomer(edit.x_m, edit.y_m)
                if newcomer is not None:
                    self.env.add_person(newcomer)
        for lead in leads.values():
            dt_s = self.env.episode_config.clock.decision_s
            self._hand.lead(lead.person, lead.x_m, lead.y_m, dt_s)
