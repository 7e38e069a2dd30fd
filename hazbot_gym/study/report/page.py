"""Report page ``report.html``: one self-contained file, made from the records alone.

The templates in ``template/`` are filled by ``tables``, ``oracle_tables``, ``figures``, ``maps``,
``replays`` and ``player``.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeVar, cast

from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.study import costs, store
from hazbot_gym.study.answer import pareto_optimal, verdict
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.costs import Training
from hazbot_gym.study.headline import groups, headline, pooled_sets, scenarios_of
from hazbot_gym.study.replay_records import Replays, from_rows
from hazbot_gym.study.report import figures, maps, oracle_tables, player, tables
from hazbot_gym.study.report.figures import Figure
from hazbot_gym.study.report.packing import packed_json, packed_text
from hazbot_gym.study.report.style import DASHES, MARKS, Style, styles
from hazbot_gym.study.results import Family, SetResults, Summary
from hazbot_gym.study.set_descriptions import describe
from hazbot_gym.utils import files
from hazbot_gym.utils.files import LONGEST

try:
    import jinja2
except ImportError as error:
    raise MissingExtra("jinja2", "study") from error

if TYPE_CHECKING:
    import pandas as pd

# Foreign records with a valid checksum can hold values of any type and size, and raise these.
_UNFIT = (
    OSError,
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    ArithmeticError,
    MemoryError,
    RecursionError,
    jinja2.TemplateError,
)


Part = TypeVar("Part")


class Study(NamedTuple):
    """The records of a finished study."""

    config: StudyConfig
    manifest: Mapping[str, object]
    summary: Summary
    rows: pd.DataFrame
    replays: Replays
    sessions: list[dict[str, object]]  # computational costs
    trainings: list[Training]  # training curves of learners, if any


def write_report(folder: Path) -> Path:
    """Write the page of a finished study beside its results, and return its path.

    Raises:
        InvalidInput: the folder holds no finished study.
    """
    study = read(folder)
    try:
        page = make_page(study)
    except _UNFIT as error:
        raise _not_finished(folder, error) from error
    path = folder / store.REPORT
    files.write_text(path, page)
    return path


def read(folder: Path) -> Study:
    """Read the records of a finished study; nothing named in a file is read, imported or run.

    Raises:
        InvalidInput: the folder holds no finished study, or one of another version.
    """
    try:
        manifest = files.read_json(folder / store.MANIFEST)
        summary = cast(Summary, files.read_json(folder / store.SUMMARY))
        rows = store.read_episodes(folder / store.EPISODES)
        config = StudyConfig.model_validate(manifest["config"])
        replays = from_rows(store.read_episodes(folder / store.REPLAYS))
        study = Study(config, manifest, summary, rows, replays, *costs.read(folder / store.COSTS))
        _check(study)
    except files.Damaged:
        raise
    except _UNFIT as error:
        raise _not_finished(folder, error) from error
    return study


def _not_finished(folder: Path, error: BaseException) -> InvalidInput:
    why = f"{type(error).__name__}: {' '.join(str(error).split())}"
    return InvalidInput(
        f"folder: given {str(folder)!r}, which holds no finished study of this version; run "
        f"hazbot study again with the same --out ({why[:LONGEST]})"
    )


def _check(study: Study) -> None:
    """Check that all files are of the same sets and policies.

    Raises:
        ValueError: they are not, or the summary is of an earlier version.
    """
    names, policies = set_names(study), set(study.config.names)
    shown = set(study.config.shown_names)
    blocks = all_blocks(study)  # KeyError where a set is missing
    if any("dominated_by" not in each for block in blocks.values() for each in block.values()):
        raise ValueError("a summary without Pareto standings, of an earlier version")
    if not set(study.summary["default_policies"]) <= shown:
        raise ValueError("policies by default that the study does not show")
    chosen = study.replays.chosen
    scenes = itertools.chain(*chosen.values(), study.replays.beside_best.values())
    if (
        any(block.keys() != policies for block in blocks.values())
        or set(study.rows["scenario_set"]) != set(names)
        or list(chosen) != names
        or any(scene.runs.keys() != shown for scene in scenes)
    ):
        raise ValueError("files of different studies")


def make_page(study: Study) -> str:
    """Return the page as HTML; the same text for the same study."""
    config, first_shown = study.config, study.summary["default_policies"]
    everybody = styles(config.names, first_shown)
    looks = {name: everybody[name] for name in dict.fromkeys([*first_shown, *config.shown_names])}
    families = styles(list(config.fronts.members)) if config.fronts else {}
    blocks = all_blocks(study)
    first = headline(study.summary)
    replays = study.replays.chosen
    plots = make_plots(study, blocks, looks)
    return (
        _environment()
        .get_template("page.html")
        .render(
            study=config,
            episodes=len(study.rows),
            manifest=study.manifest,
            everybody=everybody,
            family_looks=families,
            looks=looks,
            looks_json={
                policy: {"color": look.color, "dark": look.dark, "dash": DASHES[look.dash]}
                for policy, look in looks.items()
            },
            shades=figures.SHADES
            | {look.color: look.dark for look in (*everybody.values(), *families.values())},
            numbers={policy: i for i, policy in enumerate(everybody)},
            first_shown=first_shown,
            sets=[(each, describe(each)) for each in config.all_sets],
            headline=first,
            one_in=study.summary["headline"]["zero_is_below_one_in"],
            start=first.sets[0],
            plots=plots,
            plot_data=packed_json(plots),
            verdict=verdict(study.summary, config),
            pictures={
                name: maps.picture(some, config.reference_policy) for name, some in replays.items()
            },
            replays=player.pack(replays),
            has_gas=any(
                len(run.alarm)
                for some in replays.values()
                for each in some
                for run in each.runs.values()
            ),
            sessions=study.sessions,
            trainings=study.trainings,
            **make_tables(study, blocks),
        )
    )


def make_tables(study: Study, blocks: dict[str, SetResults]) -> dict[str, object]:
    """Return every table of the page by its name in the template."""
    config, first = study.config, headline(study.summary).policies
    pooled = {name: block for name, block in blocks.items() if name in groups(set_names(study))}
    return {
        "first_table": tables.headline(first, config.names),
        "optimal": {name: pareto_optimal(block) for name, block in blocks.items()},
        "dominated": tables.dominated(first),
        "prices": oracle_tables.price_table(first, config.names),
        "tails": oracle_tables.tail_table(first, config.names),
        "elsewhere": oracle_tables.elsewhere_tables(pooled, config.shown_names),
        "families": {
            name: oracle_tables.family_table(block) for name, block in fronts_of(study).items()
        },
        "regrets": {
            name: (oracle_tables.regret_table(block, config.names), block)
            for name, block in _in_order(study, study.summary.get("oracle", {})).items()
        },
        "tables": {
            name: (
                tables.all_metrics(block, config.names),
                tables.differences(block, config.names, config.reference_policy),
                scenarios_of(block),
            )
            for name, block in blocks.items()
        },
    }


def set_names(study: Study) -> list[str]:
    """Return the names of all sets."""
    return [scenarios.name for scenarios in study.config.all_sets]


def all_blocks(study: Study) -> dict[str, SetResults]:
    """Return the results of aggregates and single sets, most important first."""
    found = study.summary["sets"]
    first = headline(study.summary).name
    ordered = dict.fromkeys((first, *pooled_sets(study.config), *set_names(study)))
    return {name: found[name] for name in ordered}


def make_plots(
    study: Study,
    blocks: dict[str, SetResults],
    looks: Mapping[str, Style],
) -> dict[str, dict[str, Figure]]:
    """Return every plot of the page, one figure per choice of its selector."""
    replays = study.replays.chosen
    paper = {
        scenarios.name: figures.PAPER_EVENTS[scenarios.overrides["scenario"]]
        for scenarios in study.config.all_sets
        if scenarios.overrides.get("scenario") in figures.PAPER_EVENTS
    }
    return (
        {
            "front": {name: figures.front(block, looks) for name, block in blocks.items()},
            "distance": {
                name: figures.distances(some[0].runs, looks) for name, some in replays.items()
            },
            "clearance": {name: figures.clearances(block, looks) for name, block in blocks.items()},
        }
        | _optional_plots(study, looks)
        | {
            f"speed {name}": {name: figures.speeds(replays[name][0].runs, looks, events)}
            for name, events in paper.items()
        }
    )


def _optional_plots(study: Study, looks: Mapping[str, Style]) -> dict[str, dict[str, Figure]]:
    """Return the plots of fronts and oracle, if the study has them."""
    plots = {}
    if study.config.fronts is not None:
        plots["families"] = {
            name: figures.families(block) for name, block in fronts_of(study).items()
        }
    if study.replays.beside_best:
        plots["beside"] = {
            name: figures.beside_the_best(replay, looks)
            for name, replay in study.replays.beside_best.items()
        }
    return plots


def fronts_of(study: Study) -> dict[str, dict[str, Family]]:
    """Return the families' fronts, pooled and per set, in the study's order of families."""
    if study.config.fronts is None:
        return {}
    return {
        name: {family: block[family] for family in study.config.fronts.members}
        for name, block in _in_order(study, study.summary.get("fronts", {})).items()
    }


def _in_order(study: Study, found: Mapping[str, Part]) -> dict[str, Part]:
    """Return a part of the summary with aggregates first."""
    names = set_names(study)
    pooled = [name for name in found if name not in names]
    return {name: found[name] for name in (*pooled, *names) if name in found}


def _environment() -> jinja2.Environment:
    """Return the template environment, with autoescape."""
    folder = resources.files("hazbot_gym.study.report") / "template"
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: (folder / name).read_text(encoding="utf-8")),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    environment.globals |= {
        "packed": packed_text,
        "plotly": figures.library,
        "dashes": DASHES,
        "marks": MARKS,
    }
    return environment
