from __future__ import annotations

import shutil
from pathlib import Path

from hazbot_gym.policies.actor_file import read
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.training.run_folder import MANIFEST, POLICY, RESULT, claim, has_policy, has_result
from hazbot_gym.utils.files import write_json
from tests.refusals import refused


def test_new_and_empty_folders_can_be_taken(tmp_path: Path) -> None:
    for resume in (False, True):
        claim(tmp_path / "new", "me", resume=resume)
        claim(tmp_path, "me", resume=resume)


def test_one_s_own_run_is_gone_on_with_only_if_that_is_asked(tmp_path: Path) -> None:
    write_json(tmp_path / MANIFEST, {"run": "me"})
    claim(tmp_path, "me", resume=True)
    with refused("holds a run already ... --resume"):
        claim(tmp_path, "me", resume=False)


def test_another_run_and_foreign_files_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("precious")
    with refused("holds files"):
        claim(tmp_path, "me", resume=True)
    write_json(tmp_path / MANIFEST, {"run": "you"})
    with refused("another run ... you ... me"):
        claim(tmp_path, "me", resume=True)
    with refused("is a file"):
        claim(tmp_path / "thesis.tex", "me", resume=True)


def test_what_a_kill_left_before_the_manifest_was_whole_is_no_obstacle(tmp_path: Path) -> None:
    (tmp_path / f".{MANIFEST}.x1.tmp").write_text('{"run')
    claim(tmp_path, "me", resume=True)
    assert not list(tmp_path.iterdir())


def test_a_policy_or_a_result_of_another_run_counts_for_none(tmp_path: Path) -> None:
    source = SHIPPED / "ppo_tracks.npz"
    shutil.copy(source, tmp_path / POLICY)
    identity = read(source).about["training"]["run"]
    write_json(tmp_path / RESULT, {"run": identity})
    assert has_result(tmp_path, identity)
    assert not has_policy(tmp_path, "another")
    write_json(tmp_path / RESULT, {"run": "another"})
    assert not has_result(tmp_path, identity)
    assert not has_result(tmp_path, "another")
