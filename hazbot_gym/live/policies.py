"""Policies that the page offers: no other is made, so that a page can name no file and no code."""

from __future__ import annotations

from hazbot_gym.errors import InvalidInput
from hazbot_gym.live.messages import Choice
from hazbot_gym.live.settings import YOU
from hazbot_gym.policies.base import REGISTER, Policy, make

EXPERT, LEARNED = "fuzzy_expert", "ppo"  # those that a person at the page is compared with
# Label by spec, in the order of the page.
OFFERED = {
    EXPERT: "Fuzzy expert",
    LEARNED: "PPO (learned)",
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

    def choices(self) -> tuple[Choice, ...]:
        """Return the policies as choices of the page."""
        yours = Choice(name=YOU, label="You", about="arrow keys up and down")
        own = [Choice(name=spec, label=spec, about="from the command line") for spec in self._own]
        shipped = [
            Choice(name=spec, label=label, about=_about(spec), has_gas=spec in GAS_ONLY)
            for spec, label in (OFFERED | GAS_ONLY).items()
        ]
        return yours, *own, *shipped

    def make(self, spec: str) -> Policy:
        """Return a policy on offer.

        Raises:
            InvalidInput: It is not on offer.
        """
        if spec not in (*OFFERED, *GAS_ONLY, *self._own):
            raise InvalidInput(
                f"policy: given {spec!r}, which this page does not offer; start it with "
                f"hazbot play --policy {spec!r} instead"
            )
        return make(spec)


def _about(spec: str) -> str:
    return REGISTER[spec.partition(":")[0]].description
