"""Policies that the report shows by default; the others are shown on request.

At most ``MOST`` of the policies shown in plots, by the headline's mean return:

1. the reference,
2. the trained policies with the largest return, two at most,
3. the paper's fuzzy expert,
4. the rule with the largest return, of another family than the fuzzy expert,
5. the constant speeds with the largest return, three at most.
"""

from __future__ import annotations

from collections.abc import Iterator

from hazbot_gym.study.answer import learned
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.results import SetResults, mean_return

MOST = 6
EXPERT, CONSTANT = "fuzzy_expert", "constant"  # families; the paper's policy has the first's name


def family_of(policy: str) -> str:
    """Return a policy's family: its name before the options, tuned or not."""
    return policy.partition(":")[0].removesuffix(", tuned")


def default_policies(block: SetResults, study: StudyConfig) -> list[str]:
    """Return the default policies of a study, in the order of the list above.

    Args:
        block: results of the headline.
        study: its config.
    """
    return list(dict.fromkeys(_ranked(block, study)))[:MOST]


def _ranked(block: SetResults, study: StudyConfig) -> Iterator[str]:
    by_return = sorted(study.shown_names, key=lambda name: mean_return(block[name]), reverse=True)
    trained = [name for name in by_return if name in learned(study)]
    others = [name for name in by_return if name not in trained]
    yield study.reference_policy
    yield from trained[:2]
    yield from (name for name in others if name == EXPERT)
    yield from [name for name in others if family_of(name) not in (EXPERT, CONSTANT)][:1]
    yield from [name for name in others if family_of(name) == CONSTANT][:3]
