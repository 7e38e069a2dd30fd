"""A pool of threads works wherever it is taken: in a forked child, in a copy, after closing."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import threading

import pytest

from hazbot_gym.utils.threads import Threads


def test_jobs_run_on_threads_of_their_own() -> None:
    threads = Threads(2)
    assert threads.submit(threading.get_ident).result() != threading.get_ident()
    assert threads.submit(max, 3, 7).result() == 7
    threads.close()
    threads.close()
    assert threads.submit(max, 3, 7).result() == 7


@pytest.mark.filterwarnings("ignore:.*use of fork.*:DeprecationWarning")  # Python 3.12 and newer
def test_a_forked_child_starts_its_own() -> None:
    threads = Threads(2)
    threads.submit(max, 3, 7).result()
    context = multiprocessing.get_context("fork")
    results = context.SimpleQueue()

    def work_and_close() -> None:
        results.put(threads.submit(max, 3, 7).result())
        threads.close()

    child = context.Process(target=work_and_close)
    child.start()
    child.join(timeout=60.0)
    has_hung = child.is_alive()
    child.kill()
    assert not has_hung
    assert child.exitcode == 0
    assert results.get() == 7


def test_a_copy_starts_its_own() -> None:
    threads = Threads(2)
    threads.submit(max, 3, 7).result()
    for twin in (copy.deepcopy(threads), pickle.loads(pickle.dumps(threads))):
        threads.close()
        assert twin.submit(max, 3, 7).result() == 7
