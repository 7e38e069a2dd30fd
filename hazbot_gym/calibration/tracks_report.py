"""Report on track files as tables on a console, for ``hazbot tracks``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.encounter_statistics import EncounterStatistics, encounter_statistics
from hazbot_gym.task.pattern_events import EVENT_PATTERNS
from hazbot_gym.task.track_files import AS_FOUND, Options
from hazbot_gym.task.track_folders import copies, find_recordings, read_all
from hazbot_gym.task.track_statistics import Statistics, statistics
from hazbot_gym.task.tracks import Recording
from hazbot_gym.utils.terminal import FittedTable, one_line

if TYPE_CHECKING:
    from rich.console import Console


def describe(path: Path, console: Console, options: Options = AS_FOUND) -> None:
    """Print the contents of a track file or directory, and how it was read.

    Raises:
        InvalidInput: no recording, or some that cannot be read; the others are printed first.
    """
    found = read_all(path, options)
    alone = [recording for recording in found.recordings if recording.robot is None]
    numbers = {recording.name: statistics(recording) for recording in alone}
    if numbers:
        console.print(_people_table(numbers))
        console.print(_pattern_table(numbers))
    if met := encounter_statistics(found.recordings):
        console.print(_encounter_table(met))
    for recording in alone:
        _print(console, _reading(recording))
    for orphan in _descriptions_without_tables(path):
        _print(console, f"note: {orphan.name} describes no table beside it", style="yellow")
    jumps = [
        f"{name}: {each.impossible_steps} steps faster than 5 m/s"
        for name, each in numbers.items()
        if each.impossible_steps
    ]
    for doubt in [*found.doubts, *copies(found.recordings), *jumps]:
        _print(console, f"warning: {doubt}", style="yellow")
    if found.faults:
        raise InvalidInput("; ".join(found.faults))


def _reading(recording: Recording) -> str:
    """Return the columns, unit and rate used for a recording, with their sources."""
    reading = recording.reading
    assert reading is not None, "it was read from a file"
    return (
        f"{recording.name}: read as {reading.form} ({reading.form_from}), "
        f"units {reading.unit} ({reading.unit_from}), fps {reading.fps:g} ({reading.fps_from})"
    )


def _print(console: Console, line: str, style: str = "") -> None:
    console.print(one_line(line), style=style, highlight=False, soft_wrap=True)


def _descriptions_without_tables(path: Path) -> list[Path]:
    if not path.is_dir():
        return []
    stems = {file.with_suffix("") for file in find_recordings(path)}
    return [file for file in sorted(path.rglob("*.json")) if file.with_suffix("") not in stems]


def _people_table(found: dict[str, Statistics]) -> FittedTable:
    table = FittedTable(title="People")
    table.add_column("recording", overflow="fold")
    for column in (
        "people",
        "s",
        "in view\nmedian/max",
        "speed of persons\nmedian ± sd, m/s",
        "speed p5/50/95\nm/s",
        "standing",
        "nearest mean/p5/min\nm",
    ):
        table.add_column(column, justify="right")
    for name, numbers in found.items():
        p5, _, p50, _, p95 = numbers.speed_percentiles_mps
        table.add_row(
            name,
            str(numbers.people),
            f"{numbers.duration_s:.0f}",
            f"{numbers.people_in_view_median:.0f}/{numbers.people_in_view_max}",
            f"{numbers.person_speed_mps:.2f} ± {numbers.person_speed_sd_mps:.2f}",
            f"{p5:.2f}/{p50:.2f}/{p95:.2f}",
            f"{numbers.standing_share:.0%}",
            f"{numbers.nearest_mean_m:.2f}/{numbers.nearest_p5_m:.2f}/{numbers.nearest_min_m:.2f}",
        )
    return table


def _pattern_table(found: dict[str, Statistics]) -> FittedTable:
    table = FittedTable(
        title="Patterns within 3.6 m",
        caption="events (closest approach p50, m); every person in turn is the robot",
    )
    table.add_column("recording", overflow="fold")
    for pattern in EVENT_PATTERNS:
        table.add_column(pattern, justify="right")
    for name, numbers in found.items():
        counts = (numbers.patterns[pattern] for pattern in EVENT_PATTERNS)
        cells = (f"{c.events} ({c.closest_m[1]:.2f})" if c.events else "0" for c in counts)
        table.add_row(name, *cells)
    return table


def _encounter_table(met: list[EncounterStatistics]) -> FittedTable:
    table = FittedTable(
        title="Encounters of people with a robot",
        caption="closest distance between centers; speeds (median) at the closest approach",
    )
    table.add_column("scenario", overflow="fold")
    table.add_column("robot (radius)", overflow="fold")
    for column in (
        "encounters",
        "people",
        "closest p10/p50/p90\nm",
        "speed of robot\nm/s",
        "speed of person\nm/s",
    ):
        table.add_column(column, justify="right")
    for each in met:
        table.add_row(
            each.scenario,
            f"{each.robot} ({each.radius_m:.2f} m)",
            str(each.encounters),
            str(each.people),
            "/".join(f"{value:.2f}" for value in each.closest_m),
            f"{each.robot_mps:.2f}",
            f"{each.person_mps:.2f}",
        )
    return table
