"""Return of the same drives at other prices of nearness [s of delay per s of discomfort].

The reward charges ``PRICE``; recorded drives reveal 2.5 to 6.7 (``docs/encounters.md``). What holds
at each of ``PRICES`` does not depend on the reward's weight. Policies are neither tuned nor trained
again for another price.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hazbot_gym.config import Clock, RewardWeights

PRICE = -RewardWeights().intrusion / Clock().decision_s  # 4
PRICES = (PRICE / 2.0, PRICE, 2.0 * PRICE)
# Metrics of a study: the return at each price, by name.
RETURNS = {"return" if price == PRICE else f"return_at_{price:g}": price for price in PRICES}


def at_price(row: Mapping[str, Any], price: float) -> Any:
    """Return the return at another price of discomfort, of an episode, of means, or of columns."""
    return row["return"] - (price - PRICE) * row["discomfort_s"]
