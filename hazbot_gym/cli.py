"""Command line ``hazbot``: arguments and one call per command.

User errors give one line and exit code 2. Heavy imports are inside the commands, so that
``hazbot --help`` is fast.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import re
import shlex
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from hazbot_gym import __version__
from hazbot_gym.errors import HazbotError, InvalidInput
from hazbot_gym.utils import interrupts, terminal

if TYPE_CHECKING:
    from rich.console import Group

# System errors of folders and disks given by the user.
_UNUSABLE = frozenset(
    (
        errno.EACCES,
        errno.EPERM,
        errno.EROFS,
        errno.ENOSPC,
        errno.EDQUOT,
        errno.EFBIG,
        errno.EIO,
        errno.EISDIR,
        errno.ENOTDIR,
        errno.ENAMETOOLONG,
        errno.ELOOP,
    )
)


# Resumption of interrupted commands.
_GO_ON = {
    "study": "; run the same command again to go on",
    "tune": "; run the same command again to go on",
    "train": "; run it again with --resume to go on",
}
_INTERRUPTED, _TERMINATED = 130, 143  # exit codes, as shells give them


class _Terminated(KeyboardInterrupt):
    """The process was asked to end, as by ``kill`` or a job scheduler."""


def _terminate(*_: object) -> None:
    raise _Terminated


class _OneLineErrors(typer.core.TyperGroup):
    """Commands with one-line errors on stderr and exit code 2."""

    def make_context(self, info_name: str | None, args: list[str], *more: Any, **extra: Any) -> Any:
        """Parse the options before the command; show the help without arguments."""
        with _one_line_errors() if args else contextlib.nullcontext():
            for given, before in zip(args, ("", *args), strict=False):
                if not given or re.fullmatch("--[a-z-]+=", given):
                    name = given or (before if before.startswith("--") else "an argument")
                    raise InvalidInput(f"{name.strip('-=')} is empty, allowed is some text")
            return super().make_context(info_name, args, *more, **extra)

    def invoke(self, ctx: typer.Context) -> object:  # type: ignore[override]  # typer hides click's types
        try:
            with _one_line_errors():
                return super().invoke(ctx)
        except KeyboardInterrupt as error:
            how = _GO_ON.get(str(ctx.invoked_subcommand), "")
            typer.echo(f"hazbot: interrupted{how}", err=True)
            is_asked = isinstance(error, _Terminated)
            raise typer.Exit(_TERMINATED if is_asked else _INTERRUPTED) from None


@contextlib.contextmanager
def _one_line_errors() -> Iterator[None]:
    try:
        yield
        return
    except HazbotError as error:
        message = str(error)
    except typer.TyperException as error:  # an unknown option, an invalid number
        message = error.format_message()
    except OSError as error:
        if error.errno not in _UNUSABLE:
            raise
        message = f"{error.filename!r}: {error.strerror}" if error.filename else str(error.strerror)
    typer.echo(f"hazbot: {terminal.one_line(message)}", err=True)
    raise typer.Exit(2)


app = typer.Typer(
    cls=_OneLineErrors,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


# User modules are allowed on the command line, but not in files without --allow-code.
AllowCode = Annotated[
    bool,
    typer.Option("--allow-code", help="Allow module:attribute in the file to run your modules."),
]
AllowPickle = Annotated[
    bool, typer.Option("--allow-pickle", help="Allow a learned: .zip to run its pickled code.")
]


def main() -> None:
    """Run the command line."""
    # None if closed (``>&-``).
    sys.stdout, sys.stderr = (each or open(os.devnull, "w") for each in (sys.stdout, sys.stderr))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        terminal.tolerate(stream)
    terminal.warn_in_one_line()
    interrupts.repeat_ignored_interrupts()
    signal.signal(signal.SIGTERM, _terminate)  # so that worker processes end in order
    app(prog_name="hazbot")


def _show_version(is_wanted: bool) -> None:
    if is_wanted:
        typer.echo(f"hazbot {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", help="Show the version and exit.", callback=_show_version, is_eager=True
        ),
    ] = False,
) -> None:
    """A gas-inspection robot among people: run, compare and measure speed policies."""


@app.command()
def study(
    config: Annotated[
        Path | None, typer.Option(help="YAML file of overrides of the defaults.")
    ] = None,
    tracks: Annotated[
        Path | None, typer.Option(help="Folder of real tracks; adds two sets.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results. [results/study]")] = None,
    episodes: Annotated[int | None, typer.Option(help="Episodes per policy and set.")] = None,
    workers: Annotated[
        int | None,
        typer.Option(help="Cores to use; all usable ones if not given.", min=1, max=1024),
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Root of all seeds.")] = None,
    engine: Annotated[
        str | None, typer.Option(help="batched, or pymunk for the reference. [batched]")
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
def train(
    config: Annotated[
        Path | None, typer.Option(help="YAML file of overrides of the defaults.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for results. [results/train/NAME of the config]")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="Seed of weights, worlds and exploration.")
    ] = None,
    steps: Annotated[int | None, typer.Option(help="Total decisions.")] = None,
    engine: Annotated[
        str | None, typer.Option(help="batched, or pymunk for the reference. [batched]")
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Resume from the last checkpoint in the folder.")
    ] = False,
    allow_code: AllowCode = False,
    allow_pickle: AllowPickle = False,
) -> None:
    """Train a policy and export the best one. Resumable."""
    from hazbot_gym.policies import Permissions
    from hazbot_gym.training.config import load_training

    plan = load_training(config, seed=seed, steps=steps, engine=engine)
    folder = out or Path("results", "train", config.stem if config else plan.algorithm)

    from hazbot_gym.training import run as training

    result = training.train(
        plan,
        folder,
        resume=resume,
        console=terminal.progress_console(),
        allowed=Permissions(allow_pickle, allow_code),
    )
    console = terminal.output_console()
    for name, value in result.best.items():
        console.print(f"{name:24} {'-' if value is None else f'{value:10.4g}'}")
    console.print(f"The best policy on validation: {result.policy}", soft_wrap=True)


@app.command(name="eval")
def evaluate(
    policy: Annotated[str, typer.Option(help="name, name:option=value,... or module:attribute.")],
    env: Annotated[str, typer.Option(help="Environment id.")] = "hazbot_gym/Corridor-v0",
    episodes: Annotated[int, typer.Option(help="Number of episodes.")] = 20,
    seed: Annotated[int, typer.Option(help="Root of all seeds.")] = 0,
    scenario: Annotated[str | None, typer.Option(help="A named scenario, e.g. E*.")] = None,
    change: Annotated[
        list[str] | None, typer.Option("--set", help="Config value, e.g. people.count=[4,4].")
    ] = None,
    engine: Annotated[str, typer.Option(help="batched, or pymunk for the reference.")] = "batched",
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
    allow_pickle: AllowPickle = False,
) -> None:
    """Evaluate one policy in one environment."""
    from hazbot_gym.evaluation import metrics, rollout
    from hazbot_gym.study import summary, terminal_tables

    overrides = _overrides(change, scenario)
    rows = rollout.evaluate(
        policy,
        env,
        episodes=episodes,
        seed=seed,
        overrides=overrides,
        engine=engine,
        allow_pickle=allow_pickle,
    )
    if as_json:
        head = {"policy": policy, "env": env, "episodes": episodes, "seed": seed}
        typer.echo(json.dumps({**head, "metrics": metrics.means(rows)}, allow_nan=False))
    else:
        result = summary.summarise_one(rows, seed=seed)
        terminal.output_console().print(
            terminal_tables.set_table(scenario or env, {policy: result})
        )


@app.command()
def watch(
    policy: Annotated[str, typer.Option(help="name, name:option=value,... or module:attribute.")],
    env: Annotated[str, typer.Option(help="Environment id.")] = "hazbot_gym/Corridor-v0",
    episodes: Annotated[int, typer.Option(help="Number of episodes.")] = 1,
    seed: Annotated[int, typer.Option(help="Root of all seeds, as in eval.")] = 0,
    scenario: Annotated[str | None, typer.Option(help="A named scenario, e.g. E*.")] = None,
    change: Annotated[
        list[str] | None, typer.Option("--set", help="Config value, e.g. people.count=[4,4].")
    ] = None,
    speed: Annotated[float, typer.Option(help="Playback speed relative to real time.")] = 1.0,
    file: Annotated[
        Path | None, typer.Option("--save", help="Video or picture: FILE.mp4, .gif or .png.")
    ] = None,
    at: Annotated[
        float | None, typer.Option(help="Episode time of a .png in seconds; default the end.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace FILE if it exists.")] = False,
    allow_pickle: AllowPickle = False,
) -> None:
    """Watch a policy in a window, or save it. Keys: space, right arrow, r, q."""
    from hazbot_gym.viewer import watch as watching

    overrides = _overrides(change, scenario)
    show = watching.Show(policy, env, episodes, seed, overrides, speed, allow_pickle)
    if file is None:
        if at is not None:
            raise InvalidInput(f"at: given {at}, but nothing is saved; give --save FILE.png")
        rows = watching.watch_live(show)
    else:
        rows = watching.save(show, file, at_s=at, is_replacing=force)
    terminal.output_console().print(watching.table(rows))
    if file is not None:
        terminal.output_console().print(f"Saved: {file}", soft_wrap=True)


@app.command(name="list")
def list_all() -> None:
    """Show environments, named scenarios, the scenario bank and policies."""
    from hazbot_gym.study import catalogue

    console = terminal.output_console()
    for table in catalogue.tables():
        console.print(table)


@app.command()
def tracks(
    path: Annotated[Path, typer.Argument(help="Track file, or folder of track files.")],
    fps: Annotated[float | None, typer.Option(help="Frames per second.")] = None,
    units: Annotated[str | None, typer.Option(help="Unit of positions: m, cm, mm or px.")] = None,
    columns: Annotated[
        str | None, typer.Option(help="Column names from left to right, e.g. 'frame id x y -'.")
    ] = None,
    metres_per_pixel: Annotated[
        float | None, typer.Option(help="Scale of positions in pixels.")
    ] = None,
) -> None:
    """Check real track files: statistics, and the columns, unit and rate used to read them.

    The options apply to this command only; a JSON beside the file makes them permanent
    (docs/tracks.md).
    """
    from hazbot_gym.calibration import tracks_report
    from hazbot_gym.task.track_files import Options
    from hazbot_gym.task.track_formats.table import Unit

    options = Options(fps, cast("Unit | None", units), columns, metres_per_pixel)  # checked there
    tracks_report.describe(path, terminal.output_console(), options)


@app.command()
def calibrate(
    tracks: Annotated[Path | None, typer.Option(help="Folder of real tracks.")] = None,
    ratings: Annotated[
        Path | None, typer.Option(help="Folder of ratings of a robot's nearness.")
    ] = None,
    fit: Annotated[
        list[str] | None, typer.Option(help="Run to fit on; the others are held out. Repeatable.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the search or the bootstrap.", min=0)] = 0,
    as_shipped: Annotated[
        bool, typer.Option("--as-shipped", help="Evaluate the defaults without fitting.")
    ] = False,
    json_file: Annotated[Path | None, typer.Option("--json", help="Also write to FILE.")] = None,
) -> None:
    """Fit the model of people to recorded tracks, or the discomfort of nearness to ratings."""
    if (tracks is None) == (ratings is None):
        given = "neither" if tracks is None else "both"
        raise InvalidInput(f"calibrate: given {given}, allowed is one of --tracks and --ratings")
    if ratings is not None and (fit or as_shipped):
        name = "--fit" if fit else "--as-shipped"
        raise InvalidInput(f"calibrate: given {name} with --ratings, allowed with --tracks only")
    _check_file(json_file)
    if tracks is not None:
        record, tables = _people_fitted(tracks, fit, seed, as_shipped=as_shipped)
    else:
        record, tables = _discomfort_fitted(cast(Path, ratings), seed)
    _write_json(json_file, record)
    terminal.output_console().print(tables)


def _people_fitted(
    tracks: Path, fit: list[str] | None, seed: int, *, as_shipped: bool
) -> tuple[dict[str, object], Group]:
    """Return the record and the tables of ``calibrate --tracks``."""
    from hazbot_gym.calibration import fit as calibration
    from hazbot_gym.calibration import report as calibration_report
    from hazbot_gym.core.social_force import SocialForce

    runs = calibration.load_runs(tracks)
    fitted, held_out = calibration.split(runs, tuple(fit or calibration.FITTED_ON))
    force = SocialForce()
    if not as_shipped:
        total = calibration.GENERATIONS
        with terminal.progress_bar(terminal.progress_console()) as progress:
            task = progress.add_task("generations", total=total)
            force = calibration.fit(fitted, seed=seed, on_progress=lambda: progress.advance(task))
    record = calibration.report(fitted, held_out, force)
    return record, calibration_report.tables(record)


def _discomfort_fitted(folder: Path, seed: int) -> tuple[dict[str, object], Group]:
    """Return the record and the tables of ``calibrate --ratings``."""
    from hazbot_gym.calibration import discomfort, discomfort_report
    from hazbot_gym.calibration.ratings import load_ratings

    ratings = load_ratings(folder)
    with terminal.progress_bar(terminal.progress_console()) as progress:
        task = progress.add_task("bootstrap", total=discomfort.DRAWS)
        record = discomfort.report(ratings, seed=seed, on_progress=lambda: progress.advance(task))
    return record, discomfort_report.tables(record)


@app.command()
def headroom(
    env: Annotated[
        list[str] | None, typer.Option(help="Environment, e.g. Crossing-v0; all if not given.")
    ] = None,
    episodes: Annotated[
        int, typer.Option(help="Scenarios per environment.", min=1, max=100_000)
    ] = 40,
    json_file: Annotated[Path | None, typer.Option("--json", help="Also write to FILE.")] = None,
) -> None:
    """Compare rules with the exact optimum for non-reactive people (takes minutes)."""
    from hazbot_gym.envs.registration import full_id
    from hazbot_gym.evaluation.oracle import headroom as room
    from hazbot_gym.evaluation.oracle import headroom_report

    _check_file(json_file)
    known = room.environments()
    chosen = [full_id(each).rpartition("/")[2] for each in env or known]
    unknown = [name for name in chosen if name not in known]
    if unknown:
        raise InvalidInput(f"env: given {unknown[0]!r}, allowed are {', '.join(known)}")
    with terminal.progress_bar(terminal.progress_console()) as progress:
        task = progress.add_task("scenarios", total=episodes * len(chosen))
        record = room.headroom(chosen, episodes, on_progress=lambda: progress.advance(task))
    _write_json(json_file, record)
    terminal.output_console().print(headroom_report.table(record))


@app.command()
def paper(
    out: Annotated[Path | None, typer.Option(help="Folder of the results. [results/paper]")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer seeds, smaller sweeps.")] = False,
    workers: Annotated[
        int | None,
        typer.Option(help="Cores to use; all usable ones if not given.", min=1, max=1024),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace older results.")] = False,
) -> None:
    """Reproduce every experiment of the published paper, and report verdicts."""
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


@app.command()
def tune(
    policy: Annotated[str, typer.Option(help="A family of rules, e.g. ttc.")],
    trials: Annotated[int, typer.Option(help="Number of trials.", min=1, max=100_000)] = 50,
    seed: Annotated[int, typer.Option(help="Seed of the search.", min=0, max=2**64 - 1)] = 0,
    out: Annotated[
        Path | None, typer.Option(help="File of the record. [results/tune/POLICY.json]")
    ] = None,
) -> None:
    """Tune a family of rules on validation scenarios. Resumable."""
    from hazbot_gym.study import tuning
    from hazbot_gym.utils import processors

    path = out or Path("results", "tune", f"{policy}.json")
    with terminal.progress_bar(terminal.progress_console()) as progress:
        task = progress.add_task("trials", total=trials)
        record = tuning.tune(
            tuning.Search(policy, trials, seed),
            path,
            threads=processors.usable(),
            on_progress=lambda: progress.advance(task),
        )
    best, console = record["best"], terminal.output_console()
    console.print(f"{best['policy']}: validation return {best['return']:.2f}", soft_wrap=True)
    for name in record["at_a_bound"]:
        console.print(f"{name} is at a bound of its tuning space", soft_wrap=True)


@app.command()
def bench(
    quick: Annotated[bool, typer.Option("--quick", help="Rough results within seconds.")] = False,
    json_file: Annotated[Path | None, typer.Option("--json", help="Also write to FILE.")] = None,
    training: Annotated[
        list[Path] | None, typer.Option(help="Training file to measure instead. Repeatable.")
    ] = None,
) -> None:
    """Measure steps per second, beside Gymnasium's CartPole-v1 in the same run; or training."""
    _check_file(json_file)
    if training:
        _bench_training(training, json_file, seeds=1 if quick else None)
        return
    from hazbot_gym.bench import report as bench_report
    from hazbot_gym.bench import run as benchmark

    result = benchmark.bench(benchmark.QUICK if quick else benchmark.FULL)
    _write_json(json_file, result)
    terminal.output_console().print(bench_report.table(result))


def _overrides(change: list[str] | None, scenario: str | None) -> dict[str, object]:
    """Return the config values of ``--set`` and ``--scenario``."""
    from hazbot_gym.evaluation.scenario_set import parse_overrides

    overrides = parse_overrides(change or [])
    if scenario and "scenario" in overrides:
        raise InvalidInput("scenario: given by --scenario and by --set, allowed is once")
    return overrides | ({"scenario": scenario} if scenario else {})


def _bench_training(paths: list[Path], json_file: Path | None, *, seeds: int | None) -> None:
    from hazbot_gym.bench import training as bench_training
    from hazbot_gym.bench import training_report

    record = bench_training.bench_training(paths, seeds=seeds or bench_training.SEEDS)
    _write_json(json_file, record)
    terminal.output_console().print(training_report.table(record))


def _check_file(file: Path | None) -> None:
    """Raise before any work if a file cannot be written."""
    from hazbot_gym.utils.files import check_writable

    if file is None:
        return
    if not file.absolute().parent.is_dir():
        raise InvalidInput(f"json: given {str(file)!r}, whose folder does not exist")
    check_writable(file, "json")


def _write_json(file: Path | None, content: dict[str, object]) -> None:
    from hazbot_gym.utils.files import write_json

    if file is not None:
        write_json(file, content, is_sorted=False)
