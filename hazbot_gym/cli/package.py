"""Commands about the package: ``list``, ``bench``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hazbot_gym.cli.application import app
from hazbot_gym.cli.shared import JsonFile, check_file, write_record
from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils import terminal


@app.command(name="list")
def list_all() -> None:
    """Show environments, named scenarios, the scenario bank and policies."""
    from hazbot_gym.study import catalogue

    console = terminal.output_console()
    for table in catalogue.tables():
        console.print(table)


@app.command()
def bench(
    quick: Annotated[
        bool, typer.Option("--quick", help="Take seconds, with rough results.")
    ] = False,
    json_file: JsonFile = None,
    training: Annotated[
        list[Path] | None, typer.Option(help="Training file to measure instead. Repeatable.")
    ] = None,
    latency: Annotated[
        bool, typer.Option("--latency", help="Measure the answers of SpeedController instead.")
    ] = False,
    export: Annotated[
        bool, typer.Option("--export", help="Measure exports on an emulated Cortex-M3 instead.")
    ] = False,
) -> None:
    """Measure steps per second beside CartPole-v1's, or one of training, latency, exports."""
    check_file(json_file)
    given = {"training": training, "latency": latency, "export": export}
    if len(asked := [name for name, value in given.items() if value]) > 1:
        raise InvalidInput(f"{asked[1]}: given with {asked[0]}, allowed is one of them")
    if export:
        _bench_export(json_file)
        return
    if latency:
        _bench_latency(json_file, is_quick=quick)
        return
    if training:
        _bench_training(training, json_file, seeds=1 if quick else None)
        return
    from hazbot_gym.bench import report as bench_report
    from hazbot_gym.bench import run as benchmark

    result = benchmark.bench(benchmark.QUICK if quick else benchmark.FULL)
    write_record(json_file, result)
    terminal.output_console().print(bench_report.table(result))


def _bench_training(paths: list[Path], json_file: Path | None, *, seeds: int | None) -> None:
    from hazbot_gym.bench import training as bench_training
    from hazbot_gym.bench import training_report

    record = bench_training.bench_training(paths, seeds=seeds or bench_training.SEEDS)
    write_record(json_file, record)
    terminal.output_console().print(training_report.table(record))


def _bench_latency(json_file: Path | None, *, is_quick: bool) -> None:
    from hazbot_gym.bench import latency

    record = latency.bench_latency(latency.QUICK_STEPS if is_quick else latency.STEPS)
    write_record(json_file, record)
    terminal.output_console().print(latency.table(record))


def _bench_export(json_file: Path | None) -> None:
    from hazbot_gym.bench import export

    record = export.bench_export()
    write_record(json_file, record)
    for table in export.tables(record):
        terminal.output_console().print(table)
