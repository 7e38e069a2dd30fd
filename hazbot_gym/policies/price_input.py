"""Price of nearness as the last input of a policy: one network for every price.

A reward-conditioned policy (compare Abels et al., ICML 2019) observes at which price, in seconds of
delay per second of full discomfort, it is to drive. The entry is the price on a logarithmic scale,
-1 at the lowest and 1 at the highest price of the training. At one price the entry is constant, so
the first layer's bias absorbs it, and what is left is a plain actor:

    y = x W + entry w + b = x W + (b + entry w)     w: the last row of the weights
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.layer import Layer

Floats = npt.NDArray[np.float64]


class PriceInput(NamedTuple):
    """Range of prices that a policy was trained for [s of delay per s of discomfort]."""

    low: float
    high: float
    usual: float  # the price of its environments

    def entry(self, price: float | Floats) -> Floats:
        """Return the observation entry of prices, in [-1, 1]."""
        entry: Floats = 2.0 * np.log(np.divide(price, self.low)) / self._octaves - 1.0
        return entry

    def price(self, entry: Floats) -> Floats:
        """Return the prices of observation entries, the inverse of ``entry``."""
        price: Floats = self.low * np.exp(0.5 * (entry + 1.0) * self._octaves)
        return price

    @property
    def _octaves(self) -> float:
        return math.log(self.high / self.low)


def at_price(actor: Actor, prices: PriceInput | None, price: float | None) -> Actor:
    """Return an actor at one price, without the input.

    Args:
        actor: An actor whose last input is the price, unless ``prices`` is None.
        prices: The prices that it was trained for; None for an actor without this input.
        price: The price; None for the price of its environments.

    Raises:
        InvalidInput: The price is outside the range, or the actor has no such input.
    """
    if prices is None:
        if price is not None:
            raise InvalidInput(f"price: given {price:g}, but this policy has no such input")
        return actor
    price = prices.usual if price is None else price
    if not prices.low <= price <= prices.high:
        raise InvalidInput(
            f"price: given {price:g}, this policy was trained for {prices.low:g} to {prices.high:g}"
        )
    first, *others = actor.layers
    bias = first.bias + np.float32(prices.entry(price)) * first.weight[-1]
    return actor._replace(layers=(Layer(first.weight[:-1], bias), *others))
