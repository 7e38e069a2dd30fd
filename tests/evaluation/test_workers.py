"""Worker processes, whose parent may be killed at any moment."""

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hazbot_gym.evaluation import workers

PARENT = """
import os, time
from hazbot_gym.evaluation.workers import processes

if __name__ == "__main__":
    with processes(1) as pool:
        pool.submit(os.getpid).result()
        print("at work", flush=True)
        pool.submit(time.sleep, 600).result()
"""


INTERRUPTED = """
import os, signal, time
from hazbot_gym.evaluation.workers import processes

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
    try:
        with processes(2) as pool:
            pool.submit(os.getpid).result()
            waiting = pool.submit(time.sleep, 600)
            os.kill(os.getpid(), signal.SIGINT)
            waiting.result()
    except KeyboardInterrupt:
        print("interrupted")
"""


def test_no_file_of_the_working_folder_is_run_in_a_worker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("pickle", "socket", "selectors"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('run from the working folder')\n")
    monkeypatch.chdir(tmp_path)
    before = dict(os.environ)
    with workers.processes(1) as pool:
        assert pool.submit(math.sqrt, 4.0).result() == 2.0
    assert dict(os.environ) == before


WARNS = """
import warnings
from hazbot_gym.errors import DoubtfulPlace
from hazbot_gym.evaluation.workers import processes

if __name__ == "__main__":
    with processes(1) as pool:
        pool.submit(warnings.warn, "too narrow", DoubtfulPlace).result()
        pool.submit(warnings.warn, "another", UserWarning).result()
"""


def test_doubts_that_the_parent_has_said_are_not_said_by_workers() -> None:
    done = subprocess.run([sys.executable, "-c", WARNS], capture_output=True, text=True)
    assert "too narrow" not in done.stderr
    assert "another" in done.stderr


def test_an_interrupt_of_the_parent_alone_ends_its_workers() -> None:
    command = [sys.executable, "-c", INTERRUPTED]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "interrupted\n", "")


def test_workers_of_a_killed_parent_do_not_go_on() -> None:
    command = [sys.executable, "-c", PARENT]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == "at work\n"
        parent.kill()
        # The worker has the other end of the pipe too: it closes when both are gone.
        assert parent.communicate(timeout=60) == ("", None)
