"""Options and helpers that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hazbot_gym.errors import InvalidInput

# User modules are allowed on the command line, but not in files without --allow-code.
AllowCode = Annotated[
    bool,
    typer.Option("--allow-code", help="Allow module:attribute in the config to run your modules."),
]
AllowPickle = Annotated[
    bool,
    typer.Option(
        "--allow-pickle", help="Allow a policy learned:path=FILE.zip to run its pickled code."
    ),
]

Cluster = Annotated[
    str | None,
    typer.Option(help="Run on a Ray cluster: its address, or auto on one of its machines."),
]
ConfigFile = Annotated[Path | None, typer.Option(help="YAML file of overrides of the defaults.")]
PolicySpec = Annotated[str, typer.Option(help="NAME, NAME:OPTION=VALUE,... or MODULE:ATTRIBUTE.")]
WatchedPolicies = Annotated[
    list[str],
    typer.Option(
        "--policy",
        help="As in eval, or keyboard: the arrows up and down. Repeatable: up to 4 side by side.",
    ),
]
EnvId = Annotated[str, typer.Option(help="Environment id.")]
ScenarioName = Annotated[str | None, typer.Option(help="A named scenario, e.g. E*.")]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", help="Config value, e.g. people.count=[4,4]. Repeatable."),
]
JsonFile = Annotated[
    Path | None, typer.Option("--json", help="Also write the results to this file.")
]

CORRIDOR = "hazbot_gym/Corridor-v1"  # the default environment


def overrides_of(change: list[str] | None, scenario: str | None) -> dict[str, object]:
    """Return the config values of ``--set`` and ``--scenario``."""
    from hazbot_gym.evaluation.scenario_set import parse_overrides

    overrides = parse_overrides(change or [])
    if scenario and "scenario" in overrides:
        raise InvalidInput("scenario: given by --scenario and by --set, allowed is once")
    return overrides | ({"scenario": scenario} if scenario else {})


def check_file(file: Path | None) -> None:
    """Raise before any work if a file cannot be written."""
    from hazbot_gym.utils.files import check_writable

    if file is None:
        return
    if not file.absolute().parent.is_dir():
        raise InvalidInput(f"json: given {str(file)!r}, whose folder does not exist")
    check_writable(file, "json")


def write_record(file: Path | None, content: dict[str, object]) -> None:
    """Write a record as JSON, if a file was given."""
    from hazbot_gym.utils.files import write_json

    if file is not None:
        write_json(file, content, is_sorted=False)
