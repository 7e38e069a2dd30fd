from __future__ import annotations

import pytest

from hazbot_gym import policies
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.knobs import KNOBS, sweep


@pytest.mark.parametrize("name", list(KNOBS))
def test_sweep_makes_policies_that_differ_in_the_knob_alone(name: str) -> None:
    made = [policies.make(spec) for spec in sweep(name)]
    option, values = KNOBS[name]

    assert [getattr(policy, option) for policy in made] == list(values)
    assert len(set(values)) == len(values)
    assert option + "=" in policies.names()[name]


@pytest.mark.parametrize("name", list(KNOBS))
def test_sweep_passes_through_the_default(name: str) -> None:
    option, values = KNOBS[name]
    assert getattr(policies.make(name), option) in values


def test_other_options_of_a_family_are_kept() -> None:
    assert sweep("ssm:mode=directional")[0] == "ssm:mode=directional,margin_m=-0.5"


@pytest.mark.parametrize(
    ("family", "complaint"),
    [
        ("nobody", "sweep: given 'nobody', allowed are constant"),
        ("ssm:margin_m=0.1", "sweep: given 'ssm:margin_m=0.1', but margin_m is what the sweep"),
    ],
)
def test_mistakes_are_one_line(family: str, complaint: str) -> None:
    with pytest.raises(InvalidInput, match=complaint):
        sweep(family)
