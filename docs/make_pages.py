"""Write the pages that records make: ``python docs/make_pages.py``."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from hazbot_gym.paper import docs_page
from hazbot_gym.study import (
    bench_report,
    calibration_report,
    headroom_report,
    study_report,
    training_report,
)

DOCS = Path(__file__).parent
ROOT = DOCS.parent


class Page(NamedTuple):
    """A page, what makes it of its template, and of which record."""

    name: str
    fill: Callable[..., str]
    record: Path

    def text(self) -> str:
        """Return what the template and the record make."""
        template = (DOCS / f"{self.name}.template.md").read_text(encoding="utf-8")
        content = json.loads(self.record.read_text(encoding="utf-8"))
        return self.fill(template, content, name=self.record.relative_to(ROOT).as_posix())


RECORDS = ROOT / "benchmarks"
PAGES = (
    Page("performance", bench_report.page, RECORDS / "bench.json"),
    Page("headroom", headroom_report.page, RECORDS / "headroom.json"),
    Page("people", calibration_report.page, RECORDS / "calibration.json"),
    Page("training", training_report.page, RECORDS / "training.json"),
    Page("study", study_report.page, RECORDS / "study.json"),
    Page("paper", docs_page.page, RECORDS / "paper.json"),
)

README, BEGIN, END = ROOT / "README.md", "<!-- the study's headline -->\n", "<!-- end -->"


def readme() -> str:
    """Return the README with its table as the record of the study has it."""
    before, _, rest = README.read_text(encoding="utf-8").partition(BEGIN)
    record = json.loads((RECORDS / "study.json").read_text(encoding="utf-8"))
    return f"{before}{BEGIN}{study_report.readme_table(record)}\n{END}{rest.partition(END)[2]}"


if __name__ == "__main__":
    README.write_text(readme(), encoding="utf-8")
    for page in PAGES:
        (DOCS / f"{page.name}.md").write_text(page.text(), encoding="utf-8")
