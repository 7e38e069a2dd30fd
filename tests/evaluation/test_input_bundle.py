"""Input bundles of a worker on another machine, with two folders in place of two machines."""

from __future__ import annotations

from pathlib import Path

import pytest

from hazbot_gym.errors import HazbotError
from hazbot_gym.evaluation.input_bundle import Bundle, pack, unpack
from tests.refusals import refused


@pytest.fixture
def bundle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bundle:
    here = tmp_path / "here"
    (here / "places").mkdir(parents=True)
    (here / "places" / "lab.yaml").write_text("a laboratory")
    (tmp_path / "tracks.txt").write_text("recorded")
    monkeypatch.chdir(here)
    return pack([Path("places/lab.yaml"), here / "places" / "lab.yaml", tmp_path / "tracks.txt"])


def test_files_of_the_working_folder_are_found_by_the_same_relative_path(
    bundle: Bundle, tmp_path: Path
) -> None:
    assert list(bundle.copied) == ["places/lab.yaml"]
    folder = unpack(bundle)
    assert folder is not None
    with folder:
        assert Path.cwd() == Path(folder.name).resolve() != tmp_path / "here"
        assert Path("places/lab.yaml").read_text() == "a laboratory"


def test_without_files_the_working_folder_stays(tmp_path: Path) -> None:
    here = Path.cwd()
    assert unpack(pack([])) is None
    assert Path.cwd() == here


@pytest.mark.parametrize("other", ["another recording", None])
def test_a_file_elsewhere_must_be_the_same(
    bundle: Bundle, tmp_path: Path, other: str | None
) -> None:
    file = tmp_path / "tracks.txt"
    file.write_text(other) if other else file.unlink()
    with refused("tracks.txt ... same content"):
        unpack(bundle)


def test_other_versions_are_refused_by_name(bundle: Bundle) -> None:
    other = bundle._replace(versions={**bundle.versions, "numba": "0.1"})
    with pytest.raises(HazbotError, match="numba .* 0.1"):
        unpack(other)
    with pytest.raises(HazbotError, match="other code"):
        unpack(bundle._replace(stamp="of an edited package"))
