"""Survey for gas: leaks reported and missed, and false alarms, as a reward term.

The alarm is the sensor's; a policy only chooses the speed. An alarm is caused by gas if the
sensor's response without noise exceeds ``CAUSED`` of the alarm threshold when it starts. The first
one reports the leak.
"""

from __future__ import annotations

from hazbot_gym.core.gas_sensor import Nose
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.state import Floats, GasRecord, Records
from hazbot_gym.task.outcome import RUNNING
from hazbot_gym.task.reward import SURVEY

CAUSED = 0.25  # share of the alarm threshold: an alarm is 40 times as likely as in clean air
FALSE_ALARM = -0.25  # term of a false alarm


@scalar
def survey(gas: GasRecord, outcome: int, nose: Nose) -> float:
    """Update the record by the alarm of a decision, and return the term in [-1, 1].

    1 when the leak is reported, ``FALSE_ALARM`` at a false alarm, and -1 if the episode ends with
    the leak unreported.
    """
    term = 0.0
    if gas.smell.onset == 1:
        if gas.smell.response < CAUSED * nose.threshold:
            gas.false_alarms += 1
            term = FALSE_ALARM
        elif gas.is_reported == 0:
            gas.is_reported = 1
            term = 1.0
    if outcome != RUNNING and gas.leak.is_there == 1 and gas.is_reported == 0:
        term = -1.0
    return term


@lean_kernel
def survey_kernel(gases: Records, steps: Records, noses: Records, terms: Floats) -> None:
    """Entry point from Python: ``survey`` for arrays of one record."""
    terms[SURVEY] = survey(gases[0], steps[0].outcome, noses[0])
