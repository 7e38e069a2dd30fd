"""Gymnasium's ``info`` of a batched step: arrays of N, each with a mask.

The keys are those of a single environment's ``info``, the same after every reset and step, and the
mask ``_key`` selects the reported worlds. In the autoreset mode SAME_STEP, a world with an ended
episode reports the info of its reset, and the end of the old episode under ``final_info``.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats, Records
from hazbot_gym.envs.arguments import Info
from hazbot_gym.envs.batch_step import Bools, Outputs
from hazbot_gym.envs.batch_variants import columns_of
from hazbot_gym.task.leak import gas_info
from hazbot_gym.task.outcome import CAUSE_NAMES, NOBODY, OUTCOME_NAMES, RUNNING

Names = npt.NDArray[np.object_]
Table = TypeVar("Table", bound=NamedTuple)

_OUTCOMES, _CAUSES = np.array(OUTCOME_NAMES, object), np.array(CAUSE_NAMES, object)


class Scenarios(NamedTuple):
    """Scenario labels, one entry per world."""

    keys: npt.NDArray[np.int64]
    places: Names
    times_free_s: Floats
    randomised: Names  # values by name

    def replaced(self, other: Scenarios, where: Bools) -> Scenarios:
        """Return copies with some worlds replaced from others."""
        columns = zip(self, other, strict=True)
        return Scenarios(*(np.where(where, theirs, mine) for mine, theirs in columns))


class Reported(NamedTuple):
    """Contents of infos besides the outputs of a step."""

    scenarios: Scenarios
    decision_s: float
    terms: tuple[str, ...]  # names of the reward terms
    own_terms: dict[str, dict[str, float]]  # ranges and weights of those of users


def world_info(
    reported: Reported, outputs: Outputs, gas: Records, *, told: Bools, fresh: Bools
) -> Info:
    """Return the infos of the reported worlds; fresh worlds have just been reset."""
    scenarios, records = reported.scenarios, outputs.records
    outcomes, causes = records["outcome"].copy(), records["cause"].copy()
    outcomes[fresh], causes[fresh] = RUNNING, NOBODY
    terms = outputs.terms.T.copy()
    time_s, costs = np.round(outputs.steps * reported.decision_s, 9), outputs.costs.copy()
    speeds_mps = records["contact_speed_mps"].copy()
    keys, times_free_s = scenarios.keys.copy(), scenarios.times_free_s.copy()
    silent = np.flatnonzero(fresh | ~told)
    terms[:, silent] = time_s[silent] = costs[silent] = speeds_mps[silent] = 0.0
    keys[~told] = times_free_s[~told] = 0
    values: Info = {}
    if len(gas):
        smelt = gas_info(gas)
        for value in smelt.values():
            value[~told] = 0
        values["gas"] = masked(told, **smelt)
    if reported.own_terms:
        values["own_terms"] = _constants(told, reported.own_terms)
    if any(scenarios.randomised[told]):
        values["randomised"] = columns_of(scenarios.randomised, told)
        values["_randomised"] = told.copy()
    return masked(
        told,
        scenario_key=keys,
        place=_where(told, scenarios.places.copy()),
        time_free_s=times_free_s,
        time_s=time_s,
        reward_terms=masked(told, **dict(zip(reported.terms, terms, strict=True))),
        cost=costs,
        outcome=_where(told, _OUTCOMES[outcomes]),
        contact_caused_by=_where(told, _CAUSES[causes]),
        contact_speed_mps=speeds_mps,
        **values,
    )


def _constants(told: Bools, values: dict[str, dict[str, float]]) -> Info:
    """Return numbers that are the same in all reported worlds."""
    return masked(
        told,
        **{
            name: masked(told, **{key: np.where(told, value, 0.0) for key, value in each.items()})
            for name, each in values.items()
        },
    )


def final_info(reported: Reported, outputs: Outputs, ended: Bools) -> Info:
    """Return the last observations and infos of ended episodes (SAME_STEP)."""
    observations = np.full(len(ended), None, object)
    for i in np.flatnonzero(ended):
        observations[i] = outputs.final_observations[i].copy()  # one array each
    fresh = np.zeros_like(ended)
    last = world_info(reported, outputs, outputs.final_gas, told=ended, fresh=fresh)
    return masked(ended, final_obs=observations, final_info=last)


def rows_of(table: Table, rows: npt.NDArray[np.int64]) -> Table:
    """Return some worlds' rows of a tuple of arrays; arrays without rows stay empty."""
    columns: Any = table
    return type(table)(*(column[rows] if len(column) else column for column in columns))


def masked(mask: Bools, **values: object) -> Info:
    """Return values by name, each with a copy of its mask of worlds."""
    return {**values, **{f"_{name}": mask.copy() for name in values}}


def _where(told: Bools, values: Names) -> Names:
    """Return values of the reported worlds, and None for the others."""
    values[~told] = None
    return values
