"""Worker processes, whose parent may be killed at any moment."""

import subprocess
import sys

PARENT = """
import os, time
from hazbot_gym.study.workers import processes

if __name__ == "__main__":
    with processes(1) as pool:
        pool.submit(os.getpid).result()
        print("at work", flush=True)
        pool.submit(time.sleep, 600).result()
"""


INTERRUPTED = """
import os, signal, time
from hazbot_gym.study.workers import processes

if __name__ == "__main__":
    try:
        with processes(2) as pool:
            pool.submit(os.getpid).result()
            waiting = pool.submit(time.sleep, 600)
            os.kill(os.getpid(), signal.SIGINT)
            waiting.result()
    except KeyboardInterrupt:
        print("interrupted")
"""


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
