"""Feature mask: networks without some observation entries, for ablations.

A masked entry is 0 for the network, in training and afterwards, so that export only zeros the
weights of the first layer. The base of a residual policy is not masked.
"""

from __future__ import annotations

from collections.abc import Sequence

import gymnasium
import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3.common.torch_layers import FlattenExtractor


class FeatureMask(FlattenExtractor):
    """Feature mask: sets entries to 0, as an algorithm's ``features_extractor_class``."""

    def __init__(
        self, observation_space: gymnasium.Space[npt.NDArray[np.float32]], hidden: Sequence[int]
    ) -> None:
        """Mask some entries.

        Args:
            observation_space: Unmasked space.
            hidden: Indices of the masked entries.
        """
        super().__init__(observation_space)
        seen = torch.ones(self.features_dim)
        seen[list(hidden)] = 0.0
        self.seen: torch.Tensor
        self.register_buffer("seen", seen)

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Return masked observations (N, width)."""
        features: torch.Tensor = super().forward(observations)
        return features * self.seen
