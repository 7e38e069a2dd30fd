"""The page on clusters, from its committed record."""

from __future__ import annotations

import math
from string import Template

from table_text import markdown_table

from hazbot_gym.evaluation.mirrored_folder import SEND_EVERY_S
from hazbot_gym.evaluation.workers import RETRIES
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows

MACHINES, CORES, DECISIONS = (1, 10, 100), 16, 10**9
MEASURED = (
    "where",
    "decisions a second",
    "cores that the workers got",
    "decisions a second of CPU time",
    "start",
    "command's CPU time for a call",
)
COMPUTED = ("machines", "cores", "workers", "command: shards", "command: summary", "together")


def page(template: str, record: JsonObject, *, name: str) -> str:
    """Return the page.

    Args:
        template: With ``$`` placeholders.
        record: Of ``make_cluster_record.py``.
        name: Of its file, from the root of the repository.
    """
    return Template(template).substitute(
        record["machine"],
        record=name,
        policy=record["policy"],
        episodes=f"{record['episodes']:,}",
        decisions=f"{record['local']['decisions']:,}",
        shard=record["episodes_per_shard"],
        turns=record["turns"],
        shards=f"{shards(record):,}",
        every=f"{SEND_EVERY_S:g}",
        retries=RETRIES,
        ray=record["versions"]["ray"],
        measured=markdown_table(MEASURED, measured(record)),
        computed=markdown_table(COMPUTED, [computed(record, count) for count in MACHINES]),
    )


def measured(record: JsonObject) -> Rows:
    """Return the measured rates, the local one first."""
    rows: list[tuple[str, ...]] = [("2 local processes", *_rates(record["local"]), "", "")]
    for count, found in record["nodes"].items():
        where = "1 Ray node" if count == "1" else f"{count} Ray nodes"
        start, call = f"{found['start_s']:.0f} s", f"{1000 * found['call_s']:.1f} ms"
        rows.append((where, *_rates(found), start, call))
    return rows


def _rates(found: JsonObject) -> tuple[str, str, str]:
    rate, of_a_core = found["rate"], found["rate_of_a_core"]
    return f"{rate:,}", f"{rate / of_a_core:.2f}", f"{of_a_core:,}"


def computed(record: JsonObject, machines: int) -> tuple[str, ...]:
    """Return the row of some machines: a study of ``DECISIONS`` with the measured rates."""
    nodes, driver = record["nodes"], record["driver"]
    workers = DECISIONS / (nodes["1"]["rate_of_a_core"] * CORES * machines)
    sent = shards(record) * (nodes["3"]["call_s"] + driver["write_s"])
    episodes = shards(record) * record["episodes_per_shard"]
    summed = shards(record) * driver["read_s"] + episodes * driver["summary_s"]
    together = nodes["3"]["start_s"] + max(workers, sent) + summed
    times = (minutes(each) for each in (workers, sent, summed, together))
    return (f"{machines}", f"{machines * CORES:,}", *times)


def shards(record: JsonObject) -> int:
    """Return the number of shards of ``DECISIONS``."""
    per_shard: float = (
        record["local"]["decisions"] * record["episodes_per_shard"] / record["episodes"]
    )
    return math.ceil(DECISIONS / per_shard)


def minutes(seconds: float) -> str:
    """Return a duration, in seconds below two minutes."""
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"
