"""Learned policies: from an exported file, from a Stable-Baselines3 zip, or shipped.

They act deterministically, by the most likely action; ``deterministic=False`` raises, because
exploration belongs to training and unseeded random numbers are not allowed here.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic.dataclasses import dataclass

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies import actor_file
from hazbot_gym.policies.base import OPTIONS, Policy
from hazbot_gym.policies.guard import Actions, Flags, Guarded, Observations, numbers
from hazbot_gym.policies.residual import on_its_base
from hazbot_gym.task.observation import layout_of, without_gas

SHIPPED = Path(__file__).parent / "shipped"


class TrainedActor(Guarded):
    """Policy of a NumPy actor."""

    def __init__(self, trained: actor_file.Trained) -> None:
        self.actor, self.about = trained

    def act(
        self, observation: Observations, state: Any, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, object]:
        """Return the most likely action, and the LSTM state; see ``Guarded.act``.

        Without an LSTM the state is returned unchanged.

        Raises:
            InvalidInput: The observation is of another tier, or ``deterministic`` is False.
        """
        if not deterministic:
            raise InvalidInput("deterministic: given False, a trained policy allows only True")
        layout, trained = layout_of(observation), layout_of(np.empty(self.actor.width))
        if layout.has_gas and not trained.has_gas:
            observation = without_gas(observation)
            layout = layout_of(observation)
        if trained.has_gas and not layout.has_gas:
            raise InvalidInput(
                "gas: given observations without a gas sensor, this policy was trained with one"
            )
        if layout.has_people != trained.has_people:
            raise InvalidInput(
                f"tier: given observations of {layout.width} entries, this policy was trained on "
                f"tier {self.about['tier']} with {trained.width}"
            )
        if layout.width != trained.width:
            raise InvalidInput(
                f"sensors.ring: given observations with {len(layout.sensors)} range sensors, this "
                f"policy was trained with {len(trained.sensors)}"
            )
        return self.actor.act(observation, state, starts)


class FromFile:
    """Policy that delegates to a policy read from a file."""

    def policy_for(self, observation: Observations) -> Policy:
        """Return the policy of the file for observations of this width."""
        raise NotImplementedError

    def predict(
        self,
        observation: Observations,
        state: object = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, object]:
        """Return the action of the file's policy; see ``Policy.predict``."""
        observation = numbers(observation)
        policy = self.policy_for(observation)
        return policy.predict(observation, state, episode_start, deterministic)


@dataclass(frozen=True, config=OPTIONS)
class Learned(FromFile):
    """Policy from a file exported by ``hazbot train``, or saved by Stable-Baselines3."""

    path: Path
    allow_pickle: bool = False  # reading a .zip executes its pickled code

    def __post_init__(self) -> None:
        self._policy  # noqa: B018  (a file that cannot be used is refused when the policy is made)

    def policy_for(self, observation: Observations) -> Policy:
        """Return the file's policy."""
        return self._policy

    @cached_property
    def _policy(self) -> Policy:
        if self.path.suffix != ".zip":
            network = TrainedActor(actor_file.read(self.path))
            return on_its_base(network, network.about.get("residual"))
        if not self.allow_pickle:
            raise InvalidInput(
                f"policy: reading {str(self.path)!r} runs code that is in it; if you trust it, "
                "allow that with --allow-pickle on the command line, or allow_pickle=True in Python"
            )
        from hazbot_gym.policies.from_sb3 import load_zip

        return load_zip(self.path)


@dataclass(frozen=True, config=OPTIONS)
class Ppo(FromFile):
    """The shipped PPO policies, one for each observation width."""

    def __post_init__(self) -> None:
        if not self._policies:
            raise InvalidInput(
                "policy: 'ppo' is not shipped with this version; train one with `hazbot train` and "
                "give learned:path=FILE"
            )

    @cached_property
    def _policies(self) -> dict[int, Policy]:
        found = [TrainedActor(actor_file.read(path)) for path in sorted(SHIPPED.glob("ppo_*.npz"))]
        return {
            network.actor.width: on_its_base(network, network.about.get("residual"))
            for network in found
        }

    def policy_for(self, observation: Observations) -> Policy:
        """Return the policy shipped for observations of this width.

        Raises:
            InvalidInput: None is shipped for it.
        """
        observation = without_gas(observation)
        layout = layout_of(observation)
        if layout.width not in self._policies:
            raise InvalidInput(
                f"tier or sensors.ring: given observations of {layout.width} entries with "
                f"{len(layout.sensors)} range sensors, for which no 'ppo' is shipped"
            )
        return self._policies[layout.width]
