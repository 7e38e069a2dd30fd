"""Write the pages that records make: ``python docs/make_pages.py``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import paper_page
import study_report

from hazbot_gym.bench import report as bench_report
from hazbot_gym.bench import training_report
from hazbot_gym.calibration import report as calibration_report
from hazbot_gym.evaluation.oracle import headroom_report
from hazbot_gym.utils.files import read_json

DOCS = Path(__file__).parent
ROOT = DOCS.parent


class Page(NamedTuple):
    """A page, what makes it of its template, and of which record; others by argument."""

    name: str
    fill: Callable[..., str]
    record: Path
    others: Mapping[str, Path] = MappingProxyType({})

    def text(self) -> str:
        """Return what the template and the record make."""
        template = (DOCS / f"{self.name}.template.md").read_text(encoding="utf-8")
        name = self.record.relative_to(ROOT).as_posix()
        others = {argument: read_json(path) for argument, path in self.others.items()}
        return self.fill(template, read_json(self.record), name=name, **others)


RECORDS = ROOT / "benchmarks"
PAGES = (
    Page("performance", bench_report.page, RECORDS / "bench.json"),
    Page("headroom", headroom_report.page, RECORDS / "headroom.json"),
    Page("people", calibration_report.page, RECORDS / "calibration.json"),
    Page("training", training_report.page, RECORDS / "training.json"),
    Page("study", study_report.page, RECORDS / "study.json"),
    Page(
        "paper",
        paper_page.page,
        RECORDS / "paper.json",
        {"calibration": RECORDS / "calibration.json"},
    ),
)

README, END = ROOT / "README.md", "<!-- end -->"


def readme() -> str:
    """Return the README with its table and its speeds as the records have them."""
    text = README.read_text(encoding="utf-8")
    text = _filled(text, "study", study_report.readme_table(read_json(RECORDS / "study.json")))
    return _filled(text, "speed", bench_report.readme_line(read_json(RECORDS / "bench.json")))


def _filled(text: str, block: str, content: str) -> str:
    """Return a text with new content between ``<!-- block -->`` and the next ``<!-- end -->``."""
    before, begin, rest = text.partition(f"<!-- {block} -->\n")
    return f"{before}{begin}{content}\n{END}{rest.partition(END)[2]}"


if __name__ == "__main__":
    README.write_text(readme(), encoding="utf-8")
    for page in PAGES:
        (DOCS / f"{page.name}.md").write_text(page.text(), encoding="utf-8")
