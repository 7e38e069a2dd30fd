from __future__ import annotations

import subprocess
import sys

import pytest

SLEEPS = """
import os, signal, time
from hazbot_gym.utils.interrupts import repeat_ignored_interrupts

class Finalized:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0)

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
repeat_ignored_interrupts()
try:
    thing = Finalized()
    del thing
    time.sleep(60)
except KeyboardInterrupt:
    print("interrupted")
"""
FAILS = """
from hazbot_gym.utils.interrupts import repeat_ignored_interrupts

class Finalized:
    def __del__(self):
        raise ValueError("our own mistake")

repeat_ignored_interrupts()
Finalized()
"""


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=40)


@pytest.mark.skipif(sys.platform == "win32", reason="sends signals to a thread")
def test_an_interrupt_during_a_finalizer_is_not_lost() -> None:
    done = run(SLEEPS)
    assert (done.returncode, done.stdout, done.stderr) == (0, "interrupted\n", "")


def test_other_errors_of_finalizers_are_shown() -> None:
    assert "our own mistake" in run(FAILS).stderr
