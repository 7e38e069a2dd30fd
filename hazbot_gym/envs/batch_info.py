"""What a batched step tells besides: Gymnasium's ``info``, arrays of N with a mask beside each.

A world has a key where its single environment would have it, and the mask ``_key`` says which do.
In the autoreset mode SAME_STEP a world whose episode has ended tells what a reset tells, and the
end of the old episode under ``final_info``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hazbot_gym.envs.batch import Bools, Outputs
from hazbot_gym.task.outcome import (
    CAUSE_NAMES,
    CONTACT_PERSON,
    CONTACT_WALL,
    OUTCOME_NAMES,
)
from hazbot_gym.task.reward import TERMS

Info = dict[str, Any]


def decision_info(outputs: Outputs, decision_s: float, *, told: Bools, reset: Bools) -> Info:
    """Return time, reward terms and cost of the worlds told of, zero where they were reset."""
    terms, costs = outputs.terms.T.copy(), outputs.costs.copy()
    time_s = np.round(outputs.steps * decision_s, 9)
    silent = np.flatnonzero(reset | ~told)
    terms[:, silent] = costs[silent] = time_s[silent] = 0.0
    return masked(
        told,
        time_s=time_s,
        reward_terms=masked(told, **dict(zip(TERMS, terms, strict=True))),
        cost=costs,
    )


def end_info(outputs: Outputs, ended: Bools) -> Info:
    """Return how episodes ended, where they did."""
    decisions = outputs.decisions
    outcomes = decisions["outcome"]
    touched = ended & ((outcomes == CONTACT_PERSON) | (outcomes == CONTACT_WALL))
    speeds_mps = np.zeros(len(ended))
    speeds_mps[touched] = decisions["speed_mps"][touched]
    return {
        **masked(ended, outcome=_names(OUTCOME_NAMES, outcomes, ended)),
        **masked(
            touched,
            contact_caused_by=_names(CAUSE_NAMES, decisions["cause"], touched),
            contact_speed_mps=speeds_mps,
        ),
    }


def final_info(outputs: Outputs, decision_s: float, ended: Bools) -> Info:
    """Return the last observations and infos of episodes that ended and were reset at once."""
    observations = np.full(len(ended), None, object)
    for i in np.flatnonzero(ended):
        observations[i] = outputs.final_observations[i].copy()  # each an array of its own
    last = decision_info(outputs, decision_s, told=ended, reset=np.zeros_like(ended))
    return masked(ended, final_obs=observations, final_info={**last, **end_info(outputs, ended)})


def masked(mask: Bools, **values: Any) -> Info:
    """Return values by name, and beside each a copy of the mask of those worlds that have it."""
    return {**values, **{f"_{name}": mask.copy() for name in values}}


def objects(values: Any, where: Bools) -> Any:
    """Return an array of objects with the values in some worlds, and None in the others."""
    found = np.full(len(where), None, object)
    found[where] = values
    return found


def _names(names: tuple[str, ...], codes: Any, where: Bools) -> Any:
    return objects(np.array(names, object)[codes[where]], where)
