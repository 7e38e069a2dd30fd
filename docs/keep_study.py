"""Keep studies for docs/study.md: ``python docs/keep_study.py TRACKS SONAR CONTACTS PEOPLE``."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from hazbot_gym.study import report
from hazbot_gym.study.entrants import TUNED
from hazbot_gym.study.files import write_json
from hazbot_gym.study.study_record import Record, record_of, small_record_of

RECORD = Path(__file__).parents[1] / "benchmarks" / "study.json"


def kept(folder: Path) -> Record:
    """Return the record of the study in a folder."""
    study = report.read(folder)
    tuned = {
        family: json.loads((folder / TUNED / f"{family}.json").read_text(encoding="utf-8"))
        for family in study.config.tuned
    }
    return record_of(
        {
            "summary": study.summary,
            "manifest": study.manifest,
            "sessions": study.sessions,
            "trainings": [each._asdict() for each in study.trainings],
            "policies": list(study.config.names),
            "shown": list(study.config.shown_names),
            "tuned": {
                f"{family}, tuned": {
                    "policy": found["best"]["policy"],
                    "at_a_bound": found["at_a_bound"],
                }
                for family, found in tuned.items()
            },
        }
    )


if __name__ == "__main__":
    tracks, sonar, contacts, people = (Path(folder) for folder in sys.argv[1:])
    write_json(
        RECORD,
        {
            "tracks": kept(tracks),
            "sonar": kept(sonar),
            "contacts": small_record_of(report.read(contacts).summary),
            "people": small_record_of(report.read(people).summary),
        },
    )
