"""Commands of recorded people: ``tracks``, ``calibrate``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from hazbot_gym.cli.application import app
from hazbot_gym.cli.shared import JsonFile, check_file, write_record
from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils import terminal

if TYPE_CHECKING:
    from rich.console import Group


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

    A JSON file beside the tracks makes these options permanent: see docs/tracks.md.
    """
    from hazbot_gym.calibration import tracks_report
    from hazbot_gym.task.track_files import Options
    from hazbot_gym.task.track_formats.table import Unit

    options = Options(fps, cast("Unit | None", units), columns, metres_per_pixel)  # checked there
    tracks_report.describe(path, terminal.output_console(), options)


@app.command()
def calibrate(
    tracks: Annotated[Path | None, typer.Option(help="Folder of real tracks.")] = None,
    encounters: Annotated[
        Path | None, typer.Option(help="File of people's encounters with a robot, or folder.")
    ] = None,
    ratings: Annotated[
        Path | None, typer.Option(help="Folder of ratings of a robot's proximity.")
    ] = None,
    fit: Annotated[
        list[str] | None,
        typer.Option(help="Run or scene to fit on; the others are held out. Repeatable."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the search or the bootstrap.", min=0)] = 0,
    as_shipped: Annotated[
        bool, typer.Option("--as-shipped", help="Evaluate the defaults without fitting.")
    ] = False,
    json_file: JsonFile = None,
) -> None:
    """Fit walking to tracks, responses to the robot to encounters, or discomfort to ratings."""
    sources = {"--tracks": tracks, "--encounters": encounters, "--ratings": ratings}
    given = [name for name, path in sources.items() if path is not None]
    if len(given) != 1:
        raise InvalidInput(
            f"calibrate: given {' and '.join(given) or 'no data'}, allowed is one of "
            f"{', '.join(sources)}"
        )
    if ratings is not None and (fit or as_shipped):
        name = "--fit" if fit else "--as-shipped"
        raise InvalidInput(
            f"calibrate: given {name} with --ratings, allowed with --tracks and --encounters"
        )
    check_file(json_file)
    if tracks is not None:
        record, tables = _people_fitted(tracks, fit, seed, as_shipped=as_shipped)
    elif encounters is not None:
        record, tables = _response_fitted(encounters, fit, seed, as_shipped=as_shipped)
    else:
        record, tables = _discomfort_fitted(cast(Path, ratings), seed)
    write_record(json_file, record)
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


def _response_fitted(
    path: Path, fit: list[str] | None, seed: int, *, as_shipped: bool
) -> tuple[dict[str, object], Group]:
    """Return the record and the tables of ``calibrate --encounters``."""
    from hazbot_gym.calibration import encounters, encounters_report, price

    recordings = encounters.load_encounters(path)
    fitted, held_out = encounters.split(encounters.staged(recordings), fit or ())
    recorded, response = encounters.outcomes(fitted, None), encounters.SHIPPED
    if not as_shipped:
        with terminal.progress_bar(terminal.progress_console()) as progress:
            task = progress.add_task("generations", total=encounters.GENERATIONS)
            response = encounters.fit(
                fitted, recorded, seed=seed, on_progress=lambda: progress.advance(task)
            )
    record = encounters.report(fitted, held_out, response)
    record["price"] = price.report(price.drives_of(recordings), seed=seed)
    return record, encounters_report.tables(record)


def _discomfort_fitted(folder: Path, seed: int) -> tuple[dict[str, object], Group]:
    """Return the record and the tables of ``calibrate --ratings``."""
    from hazbot_gym.calibration import discomfort, discomfort_report
    from hazbot_gym.calibration.ratings import load_ratings

    ratings = load_ratings(folder)
    with terminal.progress_bar(terminal.progress_console()) as progress:
        task = progress.add_task("bootstrap", total=discomfort.DRAWS)
        record = discomfort.report(ratings, seed=seed, on_progress=lambda: progress.advance(task))
    return record, discomfort_report.tables(record)
