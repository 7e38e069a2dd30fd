"""Catalogue of environments, named scenarios, the bank and policies, for ``hazbot list``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from hazbot_gym.config import SCENARIOS, Config, make_config
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE
from hazbot_gym.policies import base
from hazbot_gym.study import bank_sets
from hazbot_gym.utils.terminal import FittedTable


def tables() -> Iterator[FittedTable]:
    """Yield one table each of environments, scenarios, the scenario bank and policies."""
    environments = {f"{NAMESPACE}/{name}": text for name, (text, _) in ENVIRONMENTS.items()}
    yield _table("Environments", environments)
    scenarios = {name: _described(make_config(scenario=name)) for name in SCENARIOS}
    yield _table("Named scenarios of the paper (scenario=...)", scenarios)
    groups = {
        bank_sets.PREFIX + name: f"{bank_sets.size(group):8} {group.meaning}"
        for name, group in bank_sets.GROUPS.items()
    }
    yield _table("Scenario bank (sets: [bank:...] in a study)", groups)
    yield _table("Policies", base.names())


def _described(config: Config) -> str:
    """Return a scenario's place, drive and walker as text."""
    drive = "ideal drive" if config.drive.wheel_loop == "ideal" else f"motor {config.drive.plant}"
    walkers = [
        f"one walker from ({one.x_m:.3f}, {one.y_m:.3f}) m at ({one.vx_mps:.3f}, {one.vy_mps:.3f}) "
        "m/s"
        for one in config.people.walkers
    ]
    return f"{config.place}, {drive}, {', '.join(walkers) or 'no people'}"


def _table(title: str, rows: Mapping[str, str]) -> FittedTable:
    table = FittedTable(
        title=title, title_justify="left", box=None, show_header=False, pad_edge=False, spare=()
    )
    table.add_column(no_wrap=True)
    table.add_column()
    for name, description in rows.items():
        table.add_row(name, description)
    return table
