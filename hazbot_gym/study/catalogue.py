"""What there is: environments, named scenarios, the bank and policies, for ``hazbot list``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich.table import Table

from hazbot_gym.config import SCENARIOS
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE
from hazbot_gym.policies import base
from hazbot_gym.study import bank_sets


def tables() -> Iterator[Table]:
    """Yield one table each of environments, scenarios, the scenario bank and policies."""
    environments = {f"{NAMESPACE}/{name}": text for name, (text, _) in ENVIRONMENTS.items()}
    yield _table("Environments", environments)
    scenarios = {name: _walker(deltas) for name, deltas in SCENARIOS.items()}
    yield _table("Named scenarios of the paper (scenario=...)", scenarios)
    groups = {
        bank_sets.PREFIX + name: f"{bank_sets.size(group):8} {group.meaning}"
        for name, group in bank_sets.GROUPS.items()
    }
    yield _table("Scenario bank (sets: [bank:...] in a study)", groups)
    yield _table("Policies", base.names())


def _walker(deltas: Mapping[str, Any]) -> str:
    """Return where the only walker of a scenario starts and how it walks."""
    walker = deltas["people"]["walkers"][0]
    position = f"({walker['x_m']:.3f}, {walker['y_m']:.3f}) m"
    velocity = f"({walker['vx_mps']:.3f}, {walker['vy_mps']:.3f}) m/s"
    return f"one walker from {position} at {velocity}"


def _table(title: str, rows: Mapping[str, str]) -> Table:
    table = Table(title=title, title_justify="left", box=None, show_header=False, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, description in rows.items():
        table.add_row(name, description)
    return table
