"""Keep three studies for docs/policies.md: ``python docs/keep_policies.py TRACKS SONAR BEFORE``."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from hazbot_gym.study.files import write_json
from hazbot_gym.study.policies_report import record_of

RECORD = Path(__file__).parents[1] / "benchmarks" / "policies.json"

if __name__ == "__main__":
    summaries = {
        tier: json.loads((Path(folder) / "summary.json").read_text(encoding="utf-8"))
        for tier, folder in zip(("tracks", "sonar", "before"), sys.argv[1:], strict=True)
    }
    write_json(RECORD, record_of(summaries))
