"""The robot as the rules take it to be: its limits, which no observation tells.

They are those of the environment's own config (``config.Drive``, ``config.Clock``). Who drives a
robot with other limits has rules that err by so much.
"""

from __future__ import annotations

DECISION_S = 0.1  # between two observations
NOMINAL_MPS = 0.5  # speed of action +1
ACCELERATION_MPS2 = 0.5  # slew limits of the command
BRAKING_MPS2 = 1.0
