"""Robot limits assumed by the rules, which are not part of the observation.

They are the defaults of ``config.Drive`` and ``config.Clock``; for other limits the rules err
accordingly.
"""

from __future__ import annotations

DECISION_S = 0.1  # between two observations
NOMINAL_MPS = 0.5  # speed of action +1
ACCELERATION_MPS2 = 0.5  # slew limits of the command
BRAKING_MPS2 = 1.0
