"""The page on the coverage of intervals with few training seeds, from its committed record."""

from __future__ import annotations

from string import Template

from table_text import markdown_table

from hazbot_gym.utils.json_object import JsonObject

Record = JsonObject

METHODS = ("percentile", "expanded", "studentised", "student")


def page(template: str, record: Record, *, name: str) -> str:
    """Return the page: a template with its placeholders filled in.

    Args:
        template: with ``$`` placeholders.
        record: of ``docs/make_coverage.py``.
        name: of its file, from the root of the repository.
    """
    seeds = dict.fromkeys(case["seeds"] for case in record["cases"])
    ranges = [
        (str(count), *(_range(record, count, method) for method in METHODS)) for count in seeds
    ]
    models = [
        f"### {model[0].upper()}{model[1:]}\n\n{_table(record, model)}"
        for model in record["models"]
    ]
    return Template(template).substitute(
        record=name,
        studies=f"{record['studies']:,}",
        scenarios=record["scenarios"],
        resamples=f"{record['resamples']:,}",
        error=f"{100.0 * (0.05 * 0.95 / record['studies']) ** 0.5:.1f}",
        ranges=markdown_table(("seeds", *METHODS), ranges),
        models="\n\n".join(models),
    )


def _range(record: Record, seeds: int, method: str) -> str:
    """Return the least and the largest coverage of a method with so many seeds, in percent."""
    found = [
        case["methods"][method]["coverage"] for case in record["cases"] if case["seeds"] == seeds
    ]
    return f"{100.0 * min(found):.1f} to {100.0 * max(found):.1f}"


def _table(record: Record, model: str) -> str:
    """Return the coverage of every method in percent, and the widths of two of them."""
    rows = [
        (
            f"{case['statistic']}, {case['seeds']}",
            *(f"{100.0 * case['methods'][method]['coverage']:.1f}" for method in METHODS),
            *(f"{case['methods'][method]['width']:.3f}" for method in ("percentile", "student")),
        )
        for case in record["cases"]
        if case["model"] == model
    ]
    titles = ("statistic, seeds", *METHODS, "width, percentile", "width, student")
    return markdown_table(titles, rows)
