"""Every chapter in its quick form: whole, readable, and within what the paper reports."""

from __future__ import annotations

import functools
import math
import re
import xml.etree.ElementTree as ElementTree
from itertools import chain

import pytest

from hazbot_gym.paper import run
from hazbot_gym.paper.chapter import Chapter
from hazbot_gym.paper.numbers import entries, reported

SVG = "{http://www.w3.org/2000/svg}"
DIAGRAMS = {"fuzzy-pid-loop", "combined-controller"}  # without axes


@functools.cache
def chapter(name: str) -> Chapter:
    return run.run_chapter(name, True)


@pytest.mark.parametrize("name", run.CHAPTERS)
def test_a_chapter_says_what_came_out(name: str) -> None:
    found = chapter(name)
    assert set(found.here) <= set(reported().numbers)
    assert all(math.isfinite(value) for value in found.here.values())
    said = " ".join(
        chain(found.text, *(map(str, row) for table in found.tables for row in table.rows))
    )
    assert found.text
    assert not re.search(r"\bnan\b|\binf\b", said)
    for table in found.tables:
        assert {len(row) for row in table.rows} == {len(table.head)}


@pytest.mark.parametrize("name", run.CHAPTERS)
def test_pictures_can_be_read_alone(name: str) -> None:
    for picture in chapter(name).pictures:
        root = ElementTree.fromstring(picture.svg)
        texts = [element.text or "" for element in root.iter(f"{SVG}text")]
        assert picture.caption.endswith(".")
        if picture.name not in DIAGRAMS:
            assert any(re.search(r"\[[^\]]+\]$", text) for text in texts), picture.name


def test_pictures_have_names_of_their_own() -> None:
    names = [picture.name for name in run.CHAPTERS for picture in chapter(name).pictures]
    assert len(names) == len(set(names))


def test_all_numbers_are_found_and_the_verdicts_are_known() -> None:
    here = {key: value for name in run.CHAPTERS for key, value in chapter(name).here.items()}
    verdicts = {entry["id"]: entry["verdict"].partition(":")[0] for entry in entries(here)}
    missed = {name for name, verdict in verdicts.items() if verdict != "reproduced"}
    assert {name for name in missed if verdicts[name] == "not reproduced"} == {
        "passive_wheels",
        "turn_deg",
        "video_frames_hz",
        "encountering_exp_decelerates_s",
        "crossing_exp_wall_s",
        "circle_fuzzy_position_max_m",
        "circle_fuzzy_angle_max_rad",
        "circle_steady_state_ratio",
        "circle_pid_position_max_m",
        "circle_pid_angle_max_rad",
        "table3_2_y",
        "table3_2_position",
        "table3_4_y",
    }
    assert all(reported().numbers[name].reason for name in missed)
