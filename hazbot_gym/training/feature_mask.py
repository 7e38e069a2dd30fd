"""Networks that do not see all of an observation, to find out what it is good for.

A hidden entry is 0 for the network, in training and ever after, so that an exported actor needs
only zeros where its first layer would have read it. What a residual's base sees is not changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
from stable_baselines3.common.torch_layers import FlattenExtractor


class Blinkers(FlattenExtractor):
    """Observations with some entries at 0, as an algorithm's ``features_extractor_class``."""

    def __init__(self, observation_space: Any, hidden: Sequence[int]) -> None:
        """Hide some entries.

        Args:
            observation_space: What is seen by others.
            hidden: Indices of the entries that are not.
        """
        super().__init__(observation_space)
        seen = torch.ones(self.features_dim)
        seen[list(hidden)] = 0.0
        self.seen: torch.Tensor
        self.register_buffer("seen", seen)

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Return what is left of observations (N, width)."""
        features: torch.Tensor = super().forward(observations)
        return features * self.seen
