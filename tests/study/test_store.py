from __future__ import annotations

import errno
import itertools
import os
import re
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import pytest

from hazbot_gym.study import store
from hazbot_gym.utils import files
from hazbot_gym.utils.checksum import BLANK, seal
from tests.refusals import refused

ROWS = [
    {"policy": "constant:0.5", "episode": k, "return": 0.1 * k, "outcome": ""} for k in range(3)
]


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_rows_come_back_as_they_were_written(tmp_path: Path) -> None:
    shard = tmp_path / "shards" / "one.parquet"
    store.write_rows(shard, ROWS, "stamp")
    found = store.read_rows(shard, rows=3, stamp="stamp")
    assert not isinstance(found, store.Missing)
    assert found.to_dict("records") == ROWS


def test_a_shard_that_is_not_there_is_absent(tmp_path: Path) -> None:
    assert store.read_rows(tmp_path / "x", rows=3, stamp="s") == store.Missing("absent")


@pytest.mark.parametrize("cut", [0, 10, 0.5, -1])
def test_a_shard_cut_short_is_damaged(tmp_path: Path, cut: float) -> None:
    shard = tmp_path / "one.parquet"
    store.write_rows(shard, ROWS, "s")
    data = shard.read_bytes()
    shard.write_bytes(data[: int(len(data) * cut) if 0 < cut < 1 else int(cut)])
    assert store.read_rows(shard, rows=3, stamp="s") == store.Missing("damaged")


def test_a_flipped_bit_in_the_data_is_damage(tmp_path: Path) -> None:
    shard = tmp_path / "one.parquet"
    store.write_rows(shard, [{"value": float(k)} for k in range(1000)], "s")
    data = bytearray(shard.read_bytes())
    data[len(data) // 3] ^= 1
    shard.write_bytes(bytes(data))
    assert store.read_rows(shard, rows=1000, stamp="s") == store.Missing("damaged")


def flipped(path: Path) -> Iterator[int]:
    """Change one byte after the other of a file that is at hand, and put it back."""
    whole = path.read_bytes()
    bits = itertools.cycle((0x01, 0x20))  # another digit or letter; the other case
    for (place, byte), bit in zip(enumerate(whole), bits, strict=False):
        path.write_bytes(whole[:place] + bytes([byte ^ bit]) + whole[place + 1 :])
        yield place
    path.write_bytes(whole)


def test_no_byte_of_a_json_record_can_change_unnoticed(tmp_path: Path) -> None:
    path, content = tmp_path / "record.json", {"trials": [{"return": 0.25}], "policy": "ttc"}
    files.write_json(path, content)
    for _ in flipped(path):
        with refused("damaged", error=files.Damaged):
            files.read_json(path)
    assert files.read_json(path) == content


def test_no_byte_of_a_shard_can_change_unnoticed(tmp_path: Path) -> None:
    path = tmp_path / "one.parquet"
    store.write_rows(path, ROWS, "s")
    for _ in flipped(path):
        assert store.read_rows(path, rows=3, stamp="s") == store.Missing("damaged")
    assert not isinstance(store.read_rows(path, rows=3, stamp="s"), store.Missing)


def test_no_byte_of_a_study_s_rows_can_change_unnoticed(tmp_path: Path) -> None:
    path, rows = tmp_path / "episodes.parquet", pd.DataFrame(ROWS)
    store.write_episodes(path, rows)
    for _ in flipped(path):
        with refused("damaged", error=files.Damaged):
            store.read_episodes(path)
    pd.testing.assert_frame_equal(store.read_episodes(path), rows)
    pd.testing.assert_frame_equal(pd.read_parquet(path), rows)  # by others, too


@pytest.mark.parametrize("cut", [0, 1, 40, -1])
def test_a_record_cut_short_or_without_a_checksum_is_refused(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "record.json"
    files.write_json(path, {"a": 1})
    path.write_bytes(path.read_bytes()[:cut])
    with refused(error=files.Damaged):
        files.read_json(path)
    path.write_text('{"a": 1}')
    with refused(error=files.Damaged):
        files.read_json(path)
    with refused("cannot read"):
        files.read_json(tmp_path / "none.json")


@pytest.mark.parametrize(("umask", "mode"), [(0o077, 0o600), (0o022, 0o644), (0o002, 0o664)])
def test_files_get_the_permissions_that_the_umask_leaves(
    tmp_path: Path, umask: int, mode: int
) -> None:
    before = os.umask(umask)
    try:
        files.write_json(tmp_path / "new" / "record.json", {})
        files.write_text(tmp_path / "page.html", "")
    finally:
        os.umask(before)
    for name in ("new/record.json", "page.html"):
        assert (tmp_path / name).stat().st_mode & 0o777 == mode
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o777 & ~umask


def test_a_full_disk_is_one_line_and_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files.write_json(tmp_path / "record.json", {"a": 1})

    def write(path: Path, data: bytes) -> None:
        with path.open("wb") as file:
            file.write(data[:5])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", write)
    with refused("No space left on device"):
        files.write_json(tmp_path / "record.json", {"a": 2})
    assert [path.name for path in tmp_path.iterdir()] == ["record.json"]
    assert files.read_json(tmp_path / "record.json") == {"a": 1}


def test_a_shard_with_too_few_rows_is_damaged(tmp_path: Path) -> None:
    shard = tmp_path / "one.parquet"
    store.write_rows(shard, ROWS[:2], "s")
    assert store.read_rows(shard, rows=3, stamp="s") == store.Missing("damaged")


def test_a_shard_of_other_code_is_outdated(tmp_path: Path) -> None:
    shard = tmp_path / "one.parquet"
    store.write_rows(shard, ROWS, "old code")
    assert store.read_rows(shard, rows=3, stamp="new code") == store.Missing("outdated")


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "summary.json"
    files.write_json(path, {"a": 1})

    def fail(beside: Path) -> None:
        beside.write_text("half")
        raise RuntimeError("power cut")

    with pytest.raises(RuntimeError, match="power cut"):
        files.write_atomically(path, fail)
    assert [p.name for p in tmp_path.iterdir()] == ["summary.json"]
    assert files.read_json(path) == {"a": 1}


def test_json_is_sorted_and_refuses_what_is_not_finite(tmp_path: Path) -> None:
    files.write_json(tmp_path / "a.json", {"b": 1, "a": {"d": None, "c": "m²"}})
    text = (tmp_path / "a.json").read_text(encoding="utf-8")
    assert re.sub("[0-9a-f]{64}", "SHA256", text) == (
        '{\n  "a": {\n    "c": "m²",\n    "d": null\n  },\n  "b": 1,\n'
        '  "checksum": "hazbot-sha256:SHA256"\n}\n'
    )
    with pytest.raises(ValueError, match="JSON"):
        files.write_json(tmp_path / "a.json", {"x": float("nan")})


def test_a_new_an_empty_and_an_own_folder_can_be_claimed(tmp_path: Path) -> None:
    store.claim(tmp_path / "new", "me")
    assert not (tmp_path / "new").exists()
    store.claim(tmp_path, "me")
    files.write_json(tmp_path / store.MANIFEST, {"study": "me"})
    store.claim(tmp_path, "me")


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("thesis.tex", "precious", "no study's"),
        ("manifest.json", "{ half a manif", "no study's"),
        ("manifest.json", '["not", "ours"]', "no study's"),
        ("manifest.json", '{"study": "without a checksum"}', "manifest.json ... damaged"),
    ],
)
def test_a_foreign_folder_is_refused_in_one_line_and_left_alone(
    tmp_path: Path, name: str, text: str, message: str
) -> None:
    (tmp_path / name).write_text(text)
    before = contents(tmp_path)
    with refused(message):
        store.claim(tmp_path, "me")
    assert contents(tmp_path) == before


def test_the_folder_of_another_study_is_refused(tmp_path: Path) -> None:
    files.write_json(tmp_path / store.MANIFEST, {"study": "other"})
    with refused("other ... me"):
        store.claim(tmp_path, "me")


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with refused("is a file"):
        store.claim(tmp_path / "file", "me")


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with refused("cannot write"):
        files.write_json(tmp_path / "file" / "summary.json", {})


@pytest.mark.parametrize("out", ["file/run", "file/run/deep", "x" * 300])
def test_what_could_not_be_written_is_told_before_any_work(tmp_path: Path, out: str) -> None:
    (tmp_path / "file").write_text("x")
    with refused("out"):
        store.claim(tmp_path / out, "me")


@pytest.mark.parametrize("out", ["run:1", "a,b", "new/deep", "[/x]", "è", "-x"])
def test_usual_and_unusual_names_may_be_written(tmp_path: Path, out: str) -> None:
    store.claim(tmp_path / out, "me")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(files.fcntl is None, reason="needs locks")
def test_two_runs_at_once_in_one_folder_are_noticed(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with files.sole_use(out):
        with refused("another run is at work"), files.sole_use(out):
            pytest.fail("two at once")
        with files.sole_use(tmp_path / "other"):
            pass
    with files.sole_use(out):
        assert list(out.iterdir()) == []


def test_leftovers_of_a_killed_run_are_swept_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "shards").mkdir()
    keep = [tmp_path / "notes.tmp", tmp_path / "shards" / "a.parquet"]
    leftovers = [tmp_path / ".summary.json.x.tmp", tmp_path / "shards" / ".a.parquet.y.tmp"]
    for path in keep + leftovers:
        path.write_text("")
    store.remove_partial(tmp_path)
    assert all(path.exists() for path in keep)
    assert not any(path.exists() for path in leftovers)


@pytest.mark.parametrize(
    "text",
    [
        f'["{BLANK}"]',
        f'"{BLANK}"',
        f'{{"sum": "{BLANK}"}}',
        f'{{"checksum": "{BLANK}", "a": ' + "[" * 100_000,
        f'{{"checksum": "{BLANK}", "a": ' + "[" * 100_000 + "]" * 100_000 + "}",
        f"{BLANK} is no JSON",
    ],
    ids=lambda text: text[-20:],
)
def test_a_right_checksum_makes_no_record(tmp_path: Path, text: str) -> None:
    path = tmp_path / "manifest.json"
    path.write_bytes(seal(text.encode()))
    with refused(error=files.Damaged):
        files.read_json(path)
    with refused("manifest.json ... damaged"):
        files.owner(tmp_path, path.name, "run")
    path.rename(tmp_path / "rows.parquet")
    with refused(error=files.Damaged):
        store.read_episodes(tmp_path / "rows.parquet")


def test_a_small_file_of_very_many_values_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store, "MOST_VALUES", 100_000)
    path = tmp_path / "rows.parquet"
    store.write_episodes(path, pd.DataFrame({"a": [[0.0] * 200_000]}))
    assert path.stat().st_size < 5_000
    with refused("200,000 ... 100,000"):
        store.read_episodes(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_pipe_in_place_of_a_record_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "manifest.json")
    with refused("is no file"):
        files.read_json(tmp_path / "manifest.json")
