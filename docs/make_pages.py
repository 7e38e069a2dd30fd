"""Write the pages and tables that records make: ``python docs/make_pages.py``."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import benchmark_pages
import cluster_page
import coverage_page
import full_page
import full_record
import full_summary
import learning_page
import offline_page
import paper_page
import prices_page
import study_report

from hazbot_gym.utils.files import read_json

DOCS = Path(__file__).parent
ROOT = DOCS.parent
TEMPLATES, TABLES = DOCS / "_templates_md", DOCS / "tables"


class Page(NamedTuple):
    """A page of the documentation, with the record and the template that it is made of.

    Attributes:
        name: of the page and of its template, without ``.md``.
        fill: a function of template, record and the record's name that returns the page.
        record: path of the record.
        others: paths of further records, by argument of ``fill``.
    """

    name: str
    fill: Callable[..., str]
    record: Path
    others: Mapping[str, Path] = MappingProxyType({})

    def text(self) -> str:
        """Return the page."""
        template = (TEMPLATES / f"{self.name}.md").read_text(encoding="utf-8")
        name = self.record.relative_to(ROOT).as_posix()
        others = {argument: read_json(path) for argument, path in self.others.items()}
        return self.fill(template, read_json(self.record), name=name, **others)


RECORDS = ROOT / "benchmarks"
PAPER = RECORDS / "paper.json"
CALIBRATION = RECORDS / "calibration.json"
PAGES = (
    Page(
        "performance",
        benchmark_pages.performance,
        RECORDS / "bench.json",
        {"hooks": RECORDS / "hooks.json", "training": RECORDS / "training.json"},
    ),
    Page(
        "headroom",
        benchmark_pages.headroom_by_environment,
        RECORDS / "headroom.json",
        {"exact": ROOT / benchmark_pages.EXACT, "depth": ROOT / benchmark_pages.DEPTH},
    ),
    Page("gas", benchmark_pages.gas, RECORDS / "headroom_gas.json"),
    Page("people", benchmark_pages.people, CALIBRATION),
    Page("discomfort", benchmark_pages.discomfort, RECORDS / "discomfort.json"),
    Page("encounters", benchmark_pages.encounters, RECORDS / "encounters.json"),
    Page("robot", benchmark_pages.robot, RECORDS / "latency.json"),
    Page("export", benchmark_pages.export, RECORDS / "export.json"),
    Page("cluster", cluster_page.page, RECORDS / "cluster.json"),
    Page("datasets", offline_page.page, RECORDS / "offline.json"),
    Page("coverage", coverage_page.page, RECORDS / "coverage.json"),
    Page("prices", prices_page.page, RECORDS / "prices.json"),
    Page("learning", learning_page.page, RECORDS / "learning.json"),
    Page(
        "from_nothing",
        learning_page.from_nothing,
        RECORDS / "from_nothing.json",
        {"faster": RECORDS / "faster.json", "longer": RECORDS / "longer.json"},
    ),
    Page("inspection", learning_page.from_nothing, RECORDS / "inspection.json"),
    Page(
        "ablations",
        learning_page.ablations,
        RECORDS / "ablations.json",
        {"more": RECORDS / "ablations_more.json"},
    ),
    Page(
        "algorithms",
        full_page.page,
        full_record.FULL,
        {"search": RECORDS / "search.json", "slow": RECORDS / "tqc_crossq.json"},
    ),
    Page("paper", paper_page.page, PAPER, {"calibration": CALIBRATION}),
    Page("paper_tables", paper_page.page, PAPER, {"calibration": CALIBRATION}),
)

WIDTH = 128  # columns of the README
README, END = ROOT / "README.md", "<!-- end -->"


def tables() -> dict[Path, str]:
    """Return the tables in CSV that pages offer, by path."""
    paper = read_json(PAPER)
    found = {
        "study-shipped": study_report.csv_of(read_json(study_report.STUDY)["shipped"]["sets"]),
        "paper-lines": paper_page.csv_of_lines(paper),
        "paper-numbers": paper_page.csv_of_numbers(paper),
    }
    return {TABLES / f"{name}.csv": text for name, text in found.items()}


def readme() -> str:
    """Return the README with its table and its speeds as the records have them."""
    text = README.read_text(encoding="utf-8")
    study = read_json(full_record.FULL)
    many = study_report.many_text(read_json(study_report.STUDY))
    found = textwrap.fill(f"{full_summary.readme_text(study)} {many}", WIDTH)
    text = _filled(text, "study", f"{full_summary.readme_table(study)}\n\n{found}")
    bench: dict[str, Any] = read_json(RECORDS / "bench.json")
    return _filled(text, "speed", benchmark_pages.readme_speed(bench))


def _filled(text: str, block: str, content: str) -> str:
    """Return a text with new content between ``<!-- block -->`` and the next ``<!-- end -->``."""
    before, begin, rest = text.partition(f"<!-- {block} -->\n")
    return f"{before}{begin}{content}\n{END}{rest.partition(END)[2]}"


if __name__ == "__main__":
    README.write_text(readme(), encoding="utf-8")
    for page in PAGES:
        (DOCS / f"{page.name}.md").write_text(page.text(), encoding="utf-8")
    TABLES.mkdir(exist_ok=True)
    for path, text in tables().items():
        path.write_text(text, encoding="utf-8")
