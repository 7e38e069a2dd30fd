"""Keep a study for the documentation: ``python docs/keep_study.py shipped=DIR``.

``shipped`` is the study that trained the shipped policy (``configs/study_from_rules.yaml``),
``shield`` that of its contacts without and with a shield (``configs/study_shield.yaml``). The parts
tracks, sonar, observations, contacts and people are the study of the first version (docs/study.md),
until it is run again. Parts not given stay as they are.
"""

from __future__ import annotations

import sys
from pathlib import Path

from study_record import TIERS, Record, record_of, small_record_of
from study_report import EXPERT, LEARNED

from hazbot_gym.study import store
from hazbot_gym.study.candidates import TUNED
from hazbot_gym.study.report import page
from hazbot_gym.study.summary import summarise_set
from hazbot_gym.utils.files import read_json, write_json

RECORD = Path(__file__).parents[1] / "benchmarks" / "study.json"


def kept(folder: Path) -> Record:
    """Return the record of the study in a folder."""
    study = page.read(folder)
    tuned = {family: read_json(folder / TUNED / f"{family}.json") for family in study.config.tuned}
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


def kept_small(folder: Path) -> Record:
    """Return the record of a study in which nobody is tuned or trained."""
    return small_record_of(page.read(folder).summary)


def kept_shipped(folder: Path) -> Record:
    """Return the record of the study of the shipped policy, with its gain over the expert, too."""
    study = page.read(folder).config.model_copy(update={"reference": EXPERT})
    found = summarise_set(store.read_episodes(folder / store.EPISODES), study)
    return kept_small(folder) | {"over_expert": found[LEARNED]["return_gain"]}


def kept_tiers(folder: Path) -> Record:
    """Return the record of the same study on several tiers: each tier's sets together."""
    record = kept_small(folder)
    return record | {"sets": {tier: record["sets"][tier] for tier in TIERS}}


PARTS = {
    "tracks": kept,
    "sonar": kept,
    "observations": kept,
    "contacts": kept_small,
    "people": kept_small,
    "shipped": kept_shipped,
    "shield": kept_tiers,
}

if __name__ == "__main__":
    folders = dict(argument.split("=", 1) for argument in sys.argv[1:])
    record = read_json(RECORD)
    record |= {part: PARTS[part](Path(folder)) for part, folder in folders.items()}
    write_json(RECORD, record)
