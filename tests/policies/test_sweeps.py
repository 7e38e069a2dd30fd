from __future__ import annotations

import pytest

from hazbot_gym import policies
from hazbot_gym.policies.sweeps import SWEEPS, sweep
from tests.refusals import refused


@pytest.mark.parametrize("name", list(SWEEPS))
def test_sweep_makes_policies_that_differ_in_the_knob_alone(name: str) -> None:
    made = [policies.make(spec) for spec in sweep(name)]
    option, values = SWEEPS[name]

    assert [getattr(policy, option) for policy in made] == list(values)
    assert len(set(values)) == len(values)
    assert option + "=" in policies.names()[name]


@pytest.mark.parametrize("name", list(SWEEPS))
def test_sweep_passes_through_the_default(name: str) -> None:
    option, values = SWEEPS[name]
    assert getattr(policies.make(name), option) in values


def test_other_options_of_a_family_are_kept() -> None:
    assert sweep("ssm:mode=directional")[0] == "ssm:mode=directional,margin_m=-0.5"


@pytest.mark.parametrize(
    ("family", "complaint"),
    [
        ("nobody", "sweep ... 'nobody' ... constant"),
        ("ssm:margin_m=0.1", "sweep ... 'ssm:margin_m=0.1' ... margin_m"),
    ],
)
def test_mistakes_are_one_line(family: str, complaint: str) -> None:
    with refused(complaint):
        sweep(family)
