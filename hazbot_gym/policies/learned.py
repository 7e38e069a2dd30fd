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

from hazbot_gym.core.sensor_ring import names_of
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies import actor_file
from hazbot_gym.policies.base import OPTIONS, Policy
from hazbot_gym.policies.guard import Actions, Flags, Guarded, Observations, numbers
from hazbot_gym.policies.price_input import PriceInput, at_price
from hazbot_gym.policies.residual import Residual, on_its_base
from hazbot_gym.task.observation import (
    Layout,
    layout_of,
    layout_with,
    observing_layout,
    selected,
)

SHIPPED = Path(__file__).parent / "shipped"


class TrainedActor(Guarded):
    """Policy of a NumPy actor.

    Attributes:
        layout: Layout of the observations that it was trained on.
        prices: Prices of nearness that it was trained for; None if it does not observe the price.
    """

    def __init__(self, trained: actor_file.Trained, price: float | None = None) -> None:
        """Make a policy.

        Args:
            trained: The actor and its metadata.
            price: The price of nearness, for an actor that observes it; None: that of its training.

        Raises:
            InvalidInput: The actor was not trained for this price.
        """
        self.about = trained.about
        self.prices = actor_file.prices_of(self.about)
        self.actor = at_price(trained.actor, self.prices, price)
        self.layout = actor_file.layout_of_table(self.about)

    def act(
        self, observation: Observations, state: Any, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, object]:
        """Return the most likely action, and the LSTM state; see ``Guarded.act``.

        Without an LSTM the state is returned unchanged.

        Raises:
            InvalidInput: The observation lacks fields of the training, or ``deterministic`` is
                False.
        """
        if not deterministic:
            raise InvalidInput("deterministic: given False, a trained policy allows only True")
        check_fields(layout_of(observation), self.layout)
        return self.actor.act(selected(observation, self.layout), state, starts)


def lacking(given: Layout, trained: Layout) -> str:
    """Name the first field group that a policy was trained on and observations lack, if any.

    A gas sensor, or more people, may be there in addition.
    """
    if given is trained:
        return ""
    if trained.has_gas and not given.has_gas:
        return "gas: given observations without a gas sensor, this policy was trained with one"
    if given.has_people != trained.has_people:
        kind = "tracks, privileged" if trained.has_people else "sonar"
        return (
            f"tier: given observations of {given.width} entries, this policy was trained on "
            f"tier {kind} with {trained.width}"
        )
    if names_of(given.sensors) != names_of(trained.sensors):
        return f"sensors.ring: given {_ring(given)}, this policy was trained with {_ring(trained)}"
    if given.person_slots < trained.person_slots:
        return (
            f"person_slots: given observations of {given.person_slots} people, this policy was "
            f"trained with {trained.person_slots}"
        )
    return ""


def _ring(layout: Layout) -> str:
    return f"{len(layout.sensors)} range sensors ({', '.join(names_of(layout.sensors))})"


def check_fields(given: Layout, trained: Layout) -> None:
    """Raise InvalidInput if observations lack what a policy was trained on."""
    if missing := lacking(given, trained):
        raise InvalidInput(missing)


def network_of(policy: Policy) -> TrainedActor | None:
    """Return the network of a policy, alone or on a base; None if it is of another kind."""
    network = policy.network if isinstance(policy, Residual) else policy
    return network if isinstance(network, TrainedActor) else None


def trained_layout(policy: Policy) -> Layout | None:
    """Return the layout that a network, alone or on a base, was trained on; None if unknown."""
    network = network_of(policy)
    return network.layout if network else None


class FromFile:
    """Policy that delegates to a policy read from a file."""

    @property
    def prices(self) -> PriceInput | None:
        """Prices of nearness that the policy can be set to by its option ``price``, if any."""
        return None

    def policy_for(self, layout: Layout) -> Policy:
        """Return the policy of the file for observations of a layout."""
        raise NotImplementedError

    def predict(
        self,
        observation: Observations,
        state: object = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, object]:
        """Return the action of the file's policy; see ``Policy.predict``.

        Its base, if it has one, sees the same fields as in training.
        """
        observation = numbers(observation)
        given = layout_of(observation)
        if given not in self._fits:
            self._fits[given] = _fit(self.policy_for(given), given)
        policy, seen = self._fits[given]
        if seen is given:
            return policy.predict(observation, state, episode_start, deterministic)
        observation = selected(observation, seen)
        with observing_layout(seen):
            return policy.predict(observation, state, episode_start, deterministic)

    @cached_property
    def _fits(self) -> dict[Layout, tuple[Policy, Layout]]:
        """The policy for each layout of observations, and the layout of its own."""
        return {}


def _fit(policy: Policy, given: Layout) -> tuple[Policy, Layout]:
    """Return a policy, and the layout of the fields that it is given of observations.

    Raises:
        InvalidInput: They lack some of its fields.
    """
    trained = trained_layout(policy)
    if trained is None:
        return policy, given
    check_fields(given, trained)
    return policy, layout_with(given.sensors, trained.person_slots, trained.has_gas)


@dataclass(frozen=True, config=OPTIONS)
class Learned(FromFile):
    """Policy from a file exported by ``hazbot train``, or saved by Stable-Baselines3."""

    path: Path
    allow_pickle: bool = False  # reading a .zip executes its pickled code
    price: float | None = None  # of nearness, for a policy that observes it; None: of its training

    def __post_init__(self) -> None:
        self._policy  # noqa: B018  (a file that cannot be used is refused when the policy is made)

    @property
    def prices(self) -> PriceInput | None:
        """Prices of nearness that the policy can be set to by its option ``price``, if any."""
        network = network_of(self._policy)
        return network.prices if network and self.price is None else None

    def policy_for(self, layout: Layout) -> Policy:
        """Return the file's policy."""
        return self._policy

    @cached_property
    def _policy(self) -> Policy:
        if self.path.suffix != ".zip":
            network = TrainedActor(actor_file.read(self.path), self.price)
            return on_its_base(network, network.about.get("residual"))
        if self.price is not None:
            raise InvalidInput(f"price: given {self.price:g}, allowed is a policy of hazbot train")
        if not self.allow_pickle:
            raise InvalidInput(
                f"policy: reading {str(self.path)!r} runs code that is in it; if you trust it, "
                "allow that with --allow-pickle on the command line, or allow_pickle=True in Python"
            )
        from hazbot_gym.policies.from_sb3 import load_zip

        return load_zip(self.path)


@dataclass(frozen=True, config=OPTIONS)
class PpoPrices(FromFile):
    """The shipped PPO policy that observes the price of nearness, with tracked people."""

    price: float | None = None  # s of delay per s of full discomfort; None: of the environments

    def __post_init__(self) -> None:
        self._policy  # noqa: B018  (a price that is not allowed is refused when the policy is made)

    @property
    def prices(self) -> PriceInput | None:
        """Prices of nearness that the policy can be set to by its option ``price``, if any."""
        return self._policy.prices if self.price is None else None

    def policy_for(self, layout: Layout) -> Policy:
        """Return the shipped policy.

        Raises:
            InvalidInput: Observations of this layout lack some of its fields.
        """
        check_fields(layout, self._policy.layout)
        return self._policy

    @cached_property
    def _policy(self) -> TrainedActor:
        return TrainedActor(actor_file.read(SHIPPED / "prices_tracks.npz"), self.price)


@dataclass(frozen=True, config=OPTIONS)
class Ppo(FromFile):
    """The shipped PPO policies, with tracked people and without."""

    def __post_init__(self) -> None:
        if not self._policies:
            raise InvalidInput(
                "policy: 'ppo' is not shipped with this version; train one with `hazbot train` and "
                "give learned:path=FILE"
            )

    @cached_property
    def _policies(self) -> list[Policy]:
        found = [TrainedActor(actor_file.read(path)) for path in sorted(SHIPPED.glob("ppo_*.npz"))]
        return [on_its_base(network, network.about.get("residual")) for network in found]

    def policy_for(self, layout: Layout) -> Policy:
        """Return the policy shipped for observations of a layout.

        Raises:
            InvalidInput: None is shipped for it.
        """
        for policy in self._policies:
            trained = trained_layout(policy)
            if trained and not lacking(layout, trained):
                return policy
        raise InvalidInput(
            f"tier, sensors.ring or person_slots: given observations of {layout.width} entries "
            f"with {len(layout.sensors)} range sensors and {layout.person_slots} people, for which "
            "no 'ppo' is shipped"
        )
