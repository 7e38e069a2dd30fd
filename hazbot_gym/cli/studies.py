"""Commands of studies: ``study``, ``report``, ``tune``, ``headroom``, ``paper``."""

from __future__ import annotations

import shlex
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hazbot_gym.cli.application import app
from hazbot_gym.cli.shared import (
    AllowCode,
    AllowPickle,
    Changes,
    Cluster,
    ConfigFile,
    JsonFile,
    check_file,
    overrides_of,
    write_record,
)
from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils import terminal
from hazbot_gym.utils.files import read_json
from hazbot_gym.utils.json_object import JsonObject

if TYPE_CHECKING:
    from hazbot_gym.policies import Permissions


@app.command()
def study(
    config: ConfigFile = None,
    tracks: Annotated[
        Path | None, typer.Option(help="Folder of real tracks; adds two scenario sets.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results; default results/study.")
    ] = None,
    episodes: Annotated[int | None, typer.Option(help="Episodes per policy and set.")] = None,
    workers: Annotated[
        int | None,
        typer.Option(help="Cores to use; all usable ones if not given.", min=1, max=1024),
    ] = None,
    cluster: Cluster = None,
    seed: Annotated[int | None, typer.Option(help="Root of all seeds.")] = None,
    engine: Annotated[
        str | None, typer.Option(help="batched (default), or pymunk, the reference.")
    ] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report page.")] = False,
    is_verbose: Annotated[
        bool, typer.Option("--verbose", help="Print the table of every set.")
    ] = False,
    allow_code: AllowCode = False,
    allow_pickle: AllowPickle = False,
) -> None:
    """Run a study: compare policies over the same scenarios. Resumable."""
    from hazbot_gym.policies import Permissions
    from hazbot_gym.study import answer, terminal_tables
    from hazbot_gym.study import run as comparison
    from hazbot_gym.study.config import load_study

    if not no_report:
        from hazbot_gym.study.report import page as report

    plan = load_study(config, tracks=tracks, episodes=episodes, seed=seed, engine=engine)
    # Results with real tracks do not overwrite those without.
    folder = out or Path("results", "study-tracks" if plan.tracks else "study")
    summary = comparison.run_study(
        plan,
        folder,
        workers=workers,
        cluster=cluster,
        console=terminal.progress_console(),
        command=shlex.join(["hazbot", *sys.argv[1:]]),
        allowed=Permissions(allow_pickle, allow_code),
    )
    page = None if no_report else report.write_report(folder)  # before anything is printed
    console = terminal.output_console()
    console.print(terminal_tables.study_tables(summary, is_verbose=is_verbose))
    console.print(answer.answer(summary, plan))
    console.print(f"Episodes, summary and manifest: {folder}", soft_wrap=True)
    if page is not None:
        console.print(f"Report: {page}", soft_wrap=True)


@app.command(name="report")
def make_report(
    folder: Annotated[Path, typer.Argument(help="Folder of a finished study.")],
) -> None:
    """Rebuild the report page of a finished study from its records, without running code."""
    from hazbot_gym.study.report import page as report

    terminal.output_console().print(f"Report: {report.write_report(folder)}", soft_wrap=True)


@app.command()
def tune(
    policy: Annotated[str | None, typer.Option(help="A family of rules, e.g. ttc.")] = None,
    config: Annotated[
        Path | None, typer.Option(help="Search file of a learner, e.g. configs/search/sac.yaml.")
    ] = None,
    trials: Annotated[
        int | None,
        typer.Option(help="Number of trials; 50 for rules.", min=1, max=100_000),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="Seed of the search.", min=0, max=2**32 - 1)
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Default results/tune/POLICY.json, or the folder results/tune/NAME."),
    ] = None,
    cluster: Cluster = None,
    allow_code: AllowCode = False,
    allow_pickle: AllowPickle = False,
) -> None:
    """Tune a family of rules, or a learner, on validation scenarios. Resumable."""
    if (policy is None) == (config is None):
        raise InvalidInput("tune: allowed is either --policy or --config")
    if config is not None:
        if cluster:
            raise InvalidInput("cluster: given with --config, allowed is --policy")
        from hazbot_gym.policies import Permissions

        _tune_learner(config, trials, seed, out, Permissions(allow_pickle, allow_code))
    elif policy is not None:
        _tune_rules(policy, trials or 50, seed or 0, out, cluster)


def _tune_learner(
    config: Path, trials: int | None, seed: int | None, out: Path | None, allowed: Permissions
) -> None:
    from hazbot_gym.study import learner_search
    from hazbot_gym.utils.yaml_loader import read_yaml

    plan = learner_search.load_search(config, trials=trials, seed=seed)
    base = read_yaml(config.parent / plan.config, "config")
    folder = out or Path("results", "tune", config.stem)
    console = terminal.output_console()

    def told(trial: JsonObject) -> None:
        values = ", ".join(f"{name} {value}" for name, value in trial["values"].items())
        console.print(f"{trial['return']:.1f} with {values}", soft_wrap=True, highlight=False)

    record = learner_search.search(plan, base, folder, allowed=allowed, on_progress=told)
    best = record["trials"][record["best"]]
    console.print(f"Best validation return {best['return']:.2f}: {folder / learner_search.BEST}")


def _tune_rules(policy: str, trials: int, seed: int, out: Path | None, cluster: str | None) -> None:
    from hazbot_gym.evaluation.workers import Here, Place
    from hazbot_gym.study import tuning
    from hazbot_gym.utils import processors

    path, cores = out or Path("results", "tune", f"{policy}.json"), processors.usable()
    # Without a cluster threads, since processes start slowly.
    with (
        terminal.progress_bar(terminal.progress_console()) as progress,
        Place(cores, cluster).pool() if cluster else nullcontext(Here()) as pool,
    ):
        task = progress.add_task("trials", total=trials)
        record = tuning.tune(
            tuning.Search(policy, trials, seed),
            path,
            pool=pool,
            threads=1 if cluster else cores,
            on_progress=lambda: progress.advance(task),
        )
    best, console = record["best"], terminal.output_console()
    console.print(f"{best['policy']}: validation return {best['return']:.2f}", soft_wrap=True)
    for name in record["at_a_bound"]:
        console.print(f"{name} is at a bound of its tuning space", soft_wrap=True)


@app.command()
def headroom(
    env: Annotated[
        list[str] | None,
        typer.Option(help="Environment, e.g. Crossing-v1; all without gas if not given."),
    ] = None,
    episodes: Annotated[
        int, typer.Option(help="Scenarios per environment.", min=1, max=100_000)
    ] = 100,
    tuning: Annotated[
        int, typer.Option(help="Other scenarios, for tuning the rules.", min=1, max=100_000)
    ] = 60,
    rounds: Annotated[
        int, typer.Option(help="Rounds of the search per scenario.", min=1, max=100_000)
    ] = 40,
    rule: Annotated[
        list[str] | None,
        typer.Option(help="Family of rules to compare, e.g. ttc; all if not given. Repeatable."),
    ] = None,
    is_scripted: Annotated[
        bool,
        typer.Option("--scripted", help="Scripted people and ideal wheels: the exact optimum."),
    ] = False,
    change: Changes = None,
    json_file: JsonFile = None,
) -> None:
    """Compare rules with the best drive known of every scenario (takes hours; resumable)."""
    from hazbot_gym.envs.registration import full_id
    from hazbot_gym.evaluation.oracle import headroom as room
    from hazbot_gym.evaluation.oracle import headroom_report
    from hazbot_gym.evaluation.oracle.trajectory_search import Effort

    check_file(json_file)
    known = [*room.environments(), *room.environments(has_gas=True)]
    chosen = [full_id(each).rpartition("/")[2] for each in env or room.environments()]
    unknown = [name for name in chosen if name not in known]
    if unknown:
        raise InvalidInput(f"env: given {unknown[0]!r}, allowed are {', '.join(known)}")
    families = room.GAS_RULES if room.has_gas(chosen) else room.RULES
    others = [family for family in rule or () if family not in families]
    if others:
        raise InvalidInput(f"rule: given {others[0]!r}, allowed are {', '.join(families)}")
    rules, overrides = tuple(rule or families), overrides_of(change, None)
    size = room.Size(episodes, tuning, Effort(rounds=rounds), rules)
    for name in chosen:
        room.headroom_config(name, overrides, is_scripted=is_scripted)
    said = room.settings(size, overrides, is_scripted=is_scripted)
    record = {**said, "environments": _continued(json_file, said)}
    missing = [name for name in chosen if name not in record["environments"]]
    with terminal.progress_bar(terminal.progress_console()) as progress:
        task = progress.add_task("scenarios", total=episodes * len(missing))
        for name in missing:
            record["environments"][name] = room.headroom(
                name,
                size,
                overrides,
                is_scripted=is_scripted,
                on_progress=lambda: progress.advance(task),
            )
            write_record(json_file, record)
    terminal.output_console().print(headroom_report.tables(record))


def _continued(file: Path | None, settings: JsonObject) -> JsonObject:
    """Return the environments of an earlier record with the same settings."""
    if file is None or not file.exists():
        return {}
    earlier = read_json(file)
    differing = [key for key, value in settings.items() if earlier.get(key) != value]
    if differing:
        key = differing[0]
        raise InvalidInput(
            f"--json: {file} has {key} {earlier.get(key)!r}, given {settings[key]!r}; "
            "name another file, or remove it"
        )
    found: JsonObject = earlier["environments"]
    return found


@app.command()
def paper(
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results; default results/paper.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer seeds, smaller sweeps.")] = False,
    workers: Annotated[
        int | None,
        typer.Option(help="Cores to use; all usable ones if not given.", min=1, max=1024),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace older results.")] = False,
) -> None:
    """Reproduce every experiment of the published paper, with a verdict on each number."""
    from hazbot_gym.paper import run, tables

    folder = out or Path("results", "paper")
    with terminal.progress_bar(terminal.progress_console()) as progress:
        task = progress.add_task("sections", total=len(run.CHAPTERS))
        record = run.reproduce(
            folder,
            quick=quick,
            workers=workers,
            is_replacing=force,
            on_progress=lambda: progress.advance(task),
        )
    console = terminal.output_console()
    console.print(tables.verdict_table(record))
    console.print(tables.summary_line(record))
    console.print(f"Page: {folder / run.PAGE}", soft_wrap=True)
