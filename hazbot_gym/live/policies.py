"""Policies that the page offers: no other is made, so that a page can name no file and no code."""

from __future__ import annotations

from hazbot_gym.errors import InvalidInput
from hazbot_gym.live.messages import Choice
from hazbot_gym.live.settings import YOU
from hazbot_gym.policies.base import REGISTER, Policy, make
from hazbot_gym.policies.learned import FromFile
from hazbot_gym.policies.price_input import PriceInput

EXPERT, LEARNED = "fuzzy_expert", "ppo"  # those that a person at the page is compared with
# Label by spec, in the order of the page.
OFFERED = {
    EXPERT: "Fuzzy expert",
    LEARNED: "PPO (learned)",
    "ppo_prices": "PPO at any price",
    "velocity_obstacle": "Velocity obstacle",
    "idm": "Car following (IDM)",
    "mpc": "Model predictive control",
    "ssm:mode=directional": "Speed and separation",
    "ttc": "Time to collision",
    "passive_safety": "Passive safety",
    "social_force": "Social force",
    "hall_steps": "Hall's zones",
    "stop_on_sight": "Stop on sight",
    "constant:0.5": "Half speed, always",
    "constant:1": "Full speed, always",
}
GAS_ONLY = {
    "slow_on_rise": "Slow where gas rises",
    "undo_lag": "Gas sensor's lag undone",
}


class Policies:
    """The policies on offer, and those of the command line."""

    def __init__(self, *own: str) -> None:
        """Add policies of the command line; these may be files and code of the user."""
        known = OFFERED | GAS_ONLY
        self._own = [spec for spec in own if spec and spec not in known and spec != YOU]
        found = {spec: _prices_of(spec) for spec in (*known, *self._own)}
        self._prices = {spec: prices for spec, prices in found.items() if prices}

    def choices(self) -> tuple[Choice, ...]:
        """Return the policies as choices of the page."""
        yours = Choice(name=YOU, label="You", about="arrow keys up and down")
        own = [
            Choice(
                name=spec, label=spec, about="from the command line", prices=self._prices.get(spec)
            )
            for spec in self._own
        ]
        shipped = [
            Choice(
                name=spec,
                label=label,
                about=_about(spec),
                has_gas=spec in GAS_ONLY,
                prices=self._prices.get(spec),
            )
            for spec, label in (OFFERED | GAS_ONLY).items()
        ]
        return yours, *own, *shipped

    def at_price(self, spec: str, price: float | None) -> str:
        """Return the spec of a policy at a price of nearness; the same if it observes none."""
        if price is None or spec not in self._prices:
            return spec
        name, _, options = spec.partition(":")
        return f"{name}:price={price}{',' if options else ''}{options}"

    def make(self, spec: str, price: float | None = None) -> Policy:
        """Return a policy on offer, at a price of nearness if it observes one.

        Raises:
            InvalidInput: It is not on offer, or not at this price.
        """
        if spec not in (*OFFERED, *GAS_ONLY, *self._own):
            raise InvalidInput(
                f"policy: given {spec!r}, which this page does not offer; start it with "
                f"hazbot play --policy {spec!r} instead"
            )
        return make(self.at_price(spec, price))


def _prices_of(spec: str) -> PriceInput | None:
    """Return the prices that a policy can be set to; None if it observes none, or names its own."""
    policy = make(spec) if spec.partition(":")[0] in REGISTER else None
    return policy.prices if isinstance(policy, FromFile) else None


def _about(spec: str) -> str:
    return REGISTER[spec.partition(":")[0]].description
