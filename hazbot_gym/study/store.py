"""Files of a study: complete or absent, never half-written, never mixed with another study's.

    OUT/manifest.json     provenance: config, seeds, versions, commit, start time
    OUT/shards/*.parquet  rows of one policy in one set, consecutive episodes each
    OUT/episodes.parquet  all rows
    OUT/oracle.parquet oracle drives, one row per scenario, if requested
    OUT/summary.json      means and intervals, byte for byte the same for the same study
    OUT/replays.parquet   the drives shown in the report
    OUT/costs.json        computational costs: time, memory, decisions
    OUT/report.html       the report page

Every file is written under a temporary name and then renamed, and every record contains a checksum
(``utils/checksum.py``); damaged records are not used. Each shard carries a stamp of all its inputs
beyond the config (code, versions, tracks); a shard with another stamp, or one that cannot be read,
is run again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.utils import files
from hazbot_gym.utils.checksum import BLANK, seal

try:
    import pandas as pd
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError as error:
    raise MissingExtra(error.name or "pandas", "study") from error

MANIFEST, SHARDS, EPISODES, SUMMARY = "manifest.json", "shards", "episodes.parquet", "summary.json"
ORACLE, COSTS, REPORT = "oracle.parquet", "costs.json", "report.html"
REPLAYS = "replays.parquet"
MOST_VALUES = 300_000_000  # of a file; two numbers per robot-second of a million episodes
_STAMP, _CHECKSUM = b"hazbot_stamp", b"hazbot_checksum"


class Missing(NamedTuple):
    """Reason to run a shard: ``absent``, ``damaged`` or ``outdated``."""

    reason: str


def claim(folder: Path, identity: str) -> None:
    """Check that a folder is new, empty or this study's own; touch nothing.

    Raises:
        InvalidInput: the folder holds another study or foreign files, or is no folder.
    """
    found = files.owner(folder, MANIFEST, "study")
    if found not in (None, identity):
        raise InvalidInput(
            f"out: {str(folder)!r} holds another study ({found}, this one is {identity}); "
            "give another --out, or remove that folder"
        )


def write_rows(path: Path, rows: Sequence[Mapping[str, object]], stamp: str) -> None:
    """Write rows as parquet with a checksum and a stamp."""
    table = pa.Table.from_pylist(list(rows))
    _write(path, table.replace_schema_metadata({_STAMP: stamp.encode()}))


def write_episodes(path: Path, rows: pd.DataFrame) -> None:
    """Write the rows of a whole study as parquet with a checksum."""
    _write(path, pa.Table.from_pandas(rows, preserve_index=False))


def read_episodes(path: Path) -> pd.DataFrame:
    """Return the rows of a whole study.

    Raises:
        InvalidInput: The file cannot be read or is damaged.
    """
    return _read(path).to_pandas()


def read_rows(path: Path, *, rows: int, stamp: str) -> pd.DataFrame | Missing:
    """Return the rows of a shard, or the reason to run it again.

    Args:
        path: the shard.
        rows: number of rows of a complete one.
        stamp: the valid stamp.
    """
    if not path.exists():
        return Missing("absent")
    try:
        table = _read(path)
    except InvalidInput:
        return Missing("damaged")
    if (table.schema.metadata or {}).get(_STAMP) != stamp.encode():
        return Missing("outdated")
    return table.to_pandas() if table.num_rows == rows else Missing("damaged")


def _write(path: Path, table: pa.Table) -> None:
    """Write a table with a checksum of the whole file in its metadata."""
    filled = table.replace_schema_metadata({**(table.schema.metadata or {}), _CHECKSUM: BLANK})
    sink = pa.BufferOutputStream()
    pq.write_table(filled, sink)
    files.write_bytes(path, seal(sink.getvalue().to_pybytes()))


def _read(path: Path) -> pa.Table:
    data = files.read_sealed(path)
    try:
        parquet = pq.ParquetFile(pa.BufferReader(data))
        _check_size(parquet.metadata, path)
        return parquet.read()
    except (pa.ArrowException, OSError) as error:  # foreign file with a valid checksum
        raise files.Damaged(path) from error


def _check_size(about: pq.FileMetaData, path: Path) -> None:
    """Reject a small file that expands beyond the memory: compressed, or one value repeated."""
    groups = [about.row_group(i) for i in range(about.num_row_groups)]
    values = sum(group.column(i).num_values for group in groups for i in range(group.num_columns))
    most = max(about.num_rows, values, sum(group.total_byte_size for group in groups) // 8)
    if most > MOST_VALUES:
        raise InvalidInput(f"{str(path)!r} would take {most:,} values, allowed are {MOST_VALUES:,}")


def join(parts: list[pd.DataFrame]) -> pd.DataFrame:
    """Concatenate the rows of all parts."""
    return pd.concat(parts, ignore_index=True)


def withdraw(folder: Path) -> None:
    """Remove the results of a study, but not its shards."""
    for name in (EPISODES, ORACLE, SUMMARY, REPLAYS, REPORT):
        (folder / name).unlink(missing_ok=True)


def remove_partial(folder: Path) -> None:
    """Remove partial files of a killed run."""
    files.remove_partial(folder)
    files.remove_partial(folder / SHARDS)
