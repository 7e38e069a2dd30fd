"""Write docs/performance.md from a record: ``python docs/make_performance.py [RECORD]``."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from hazbot_gym.study.bench_report import page

DOCS = Path(__file__).parent
RECORD = DOCS.parent / "benchmarks" / "bench.json"


def make(record: Path = RECORD) -> str:
    """Return the page that the template and a record make."""
    template = (DOCS / "performance.template.md").read_text(encoding="utf-8")
    content = json.loads(record.read_text(encoding="utf-8"))
    return page(template, content, name=f"{record.parent.name}/{record.name}")


if __name__ == "__main__":
    text = make(*map(Path, sys.argv[1:]))
    (DOCS / "performance.md").write_text(text, encoding="utf-8")
