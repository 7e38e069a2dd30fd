from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from hazbot_gym.policies.sweeps import sweep
from hazbot_gym.study.config import Fronts, load_study
from hazbot_gym.study.front_summary import summarise_fronts
from tests.refusals import refused

INTERVAL: Any = {"resamples": 200, "confidence": 0.95, "seed": 0}


def rows(policy: str, time: float, intrusion: float, seeds: int = 1) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "policy": policy,
            "scenario_set": "a",
            "training_seed": np.repeat(np.arange(seeds), 4),
            "delay_s": time,
            "discomfort_s": intrusion,
        }
    )


def test_families_are_areas_up_to_the_corner_and_learners_may_have_other_numbers_of_seeds() -> None:
    fronts = Fronts(sets=("a",), groups={"one": ("p",), "two": ("p", "q", "r")}, corner=(2.0, 1.0))
    together = pd.concat([rows("p", 1.5, 0.5), rows("q", 1.25, 0.75, 3), rows("r", 1.6, 0.6)])
    found = summarise_fronts(together, fronts, **INTERVAL)
    assert found["one"]["hypervolume"] == pytest.approx((0.25, 0.25, 0.25))
    assert found["two"]["hypervolume"].mean == pytest.approx(0.25 + 0.25 * 0.25)
    assert found["two"]["difference"].mean == pytest.approx(0.0625)
    assert found["one"]["behind"].mean == pytest.approx(-0.0625)
    assert found["two"]["behind"] == (0.0, 0.0, 0.0)
    assert [point["on_front"] for point in found["two"]["points"]] == [True, True, False]
    assert found["two"]["points"][1]["delay_s"].mean == 1.25


def test_a_study_drives_the_sweeps_of_its_fronts_only_where_they_are_wanted() -> None:
    study = load_study(
        policies=["constant:0.5"],
        sets=["Crossing", "Leading"],
        fronts={"sets": ["Crossing"], "families": ["constant"]},
    )
    assert study.fronts is not None
    assert study.fronts.swept == {"constant": tuple(sweep("constant"))}
    assert [each.name for each in study.sets_named(study.fronts.sets)] == ["Crossing"]


@pytest.mark.parametrize(
    ("part", "named"),
    [
        ({"fronts": {"sets": ["nowhere"]}}, "fronts.sets ... 'nowhere'"),
        ({"oracle": {"sets": ["nowhere"]}}, "oracle.sets ... 'nowhere'"),
        ({"fronts": {"sets": ["Crossing"], "groups": {"g": ["who"]}}}, "fronts.groups.g"),
        ({"fronts": {"sets": ["Crossing"], "families": ["who"]}}, "sweep ... 'who'"),
    ],
)
def test_what_is_not_in_the_study_is_refused_in_one_line(part: Any, named: str) -> None:
    with refused(named):
        load_study(policies=["constant:0.5"], sets=["Crossing"], **part)
