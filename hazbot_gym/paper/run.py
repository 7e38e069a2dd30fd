"""Reproduction run: all chapters in parallel, then the result files.

OUT/paper.json       an entry per reported number, and further measurements
OUT/figures/*.svg    the pictures
OUT/paper.html       the report page, section by section, self-contained
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from concurrent.futures import as_completed
from pathlib import Path
from typing import Any

from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.workers import processes
from hazbot_gym.paper import page
from hazbot_gym.paper.chapter import Chapter
from hazbot_gym.paper.lines import lines
from hazbot_gym.paper.numbers import count_by_basis, count_verdicts, entries
from hazbot_gym.utils import files, processors, provenance
from hazbot_gym.utils.json_object import JsonObject

RECORD, PAGE, FIGURES = "paper.json", "paper.html", "figures"
# In the paper's order.
CHAPTERS = (
    "design",
    "kinematics",
    "social_force",
    "patterns",
    "speed_controller",
    "fuzzy_pid",
    "tuned_pid",
    "control_system",
    "sensors",
    "meetings",
    "circle",
    "motor",
    "combination",
)
LONGEST_FIRST = ("motor", "tuned_pid", "circle", "control_system", "speed_controller", "meetings")

Record = JsonObject


def reproduce(
    out: Path,
    *,
    quick: bool = False,
    workers: int | None = None,
    is_replacing: bool = False,
    on_progress: Callable[[], None] = lambda: None,
) -> Record:
    """Run every experiment of the paper, write the results and return the record.

    Args:
        out: Folder of the results; new, empty, or with results of the same code.
        quick: Fewer noise seeds, smaller sweeps.
        workers: Number of processes; None for one per core.
        is_replacing: Whether results of other code may be replaced.
        on_progress: Called after each chapter.

    Raises:
        InvalidInput: The folder holds something else, or cannot be written.
    """
    identity = f"{'quick' if quick else 'full'} {provenance.stamp()}"
    found = files.owner(out, RECORD, "paper")
    if found == identity and (out / PAGE).exists():  # written last
        return read(out)
    if found not in (None, identity) and not is_replacing:
        raise InvalidInput(
            f"out: {str(out)!r} holds results of other code or of another form; give --force to "
            "replace them, or another folder"
        )
    chapters = run_chapters(quick=quick, workers=workers, on_progress=on_progress)
    record = record_of(chapters, identity, quick=quick)
    files.write_json(out / RECORD, record)  # first: marks the owner of the folder
    for chapter in chapters:
        for picture in chapter.pictures:
            files.write_text(out / FIGURES / f"{picture.name}.svg", picture.svg)
    files.write_text(out / PAGE, page.make_page(record, chapters))
    return record


def read(out: Path) -> Record:
    """Return the record in a folder of results."""
    return files.read_json(out / RECORD)


def run_chapters(
    *, quick: bool, workers: int | None = None, on_progress: Callable[[], None] = lambda: None
) -> list[Chapter]:
    """Run all chapters and return them in the paper's order."""
    order = sorted(CHAPTERS, key=lambda name: name not in LONGEST_FIRST)
    with processes(workers or processors.usable()) as pool:
        jobs = {name: pool.submit(run_chapter, name, quick) for name in order}
        for job in as_completed(jobs.values()):
            job.result()
            on_progress()
        return [jobs[name].result() for name in CHAPTERS]


def run_chapter(name: str, quick: bool) -> Chapter:
    """Run one chapter."""
    chapter: Chapter = importlib.import_module(f"hazbot_gym.paper.sections.{name}.section").chapter(
        quick
    )
    return chapter


def record_of(chapters: list[Chapter], identity: str, *, quick: bool) -> Record:
    """Return the record of the chapters."""
    here = {name: value for chapter in chapters for name, value in chapter.here.items()}
    numbers = entries(here)
    return {
        "paper": identity,
        "form": "quick" if quick else "full",
        "commit": provenance.commit(),
        "versions": provenance.versions(),
        "reported": len(numbers),
        "verdicts": count_verdicts(numbers),
        "verdicts_by_basis": count_by_basis(numbers),
        "numbers": numbers,
        "sections": [
            {"number": chapter.number, "title": chapter.title, "text": list(chapter.text)}
            for chapter in chapters
        ],
        "lines": [line.model_dump() for line in lines()],
        "chapters": {chapter.number: _plain(chapter.record) for chapter in chapters},
    }


def _plain(value: object) -> Any:
    """Return values for JSON, with null for NaN and infinity."""
    if isinstance(value, dict):
        return {str(name): _plain(inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    if isinstance(value, float):
        return float(f"{value:.9g}") if math.isfinite(value) else None
    return value
