"""Parallel processes that start the same way on every system, and end with who started them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from hazbot_gym.core.notice import NOTICE
from hazbot_gym.errors import HazbotError


@contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor]:
    """Give parallel processes; what is still waiting in the end is not begun.

    Raises:
        HazbotError: One of them was ended from outside.
    """
    # Spawned processes start from nothing, the same way on every system.
    spawn = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(
        count, mp_context=spawn, initializer=_begin, initargs=(NOTICE.has_spoken,)
    )
    try:
        yield pool
    except BrokenProcessPool as error:
        raise HazbotError("a worker process was ended from outside; run again to go on") from error
    finally:
        pool.shutdown(cancel_futures=True)


def _begin(has_spoken: bool) -> None:
    """Let Ctrl-C end a worker quietly, and the end of its parent at once.

    Who is killed cannot tell its workers. Left alone they would finish what they are at, beside
    those of the run that goes on.

    Args:
        has_spoken: Whether the parent has announced that kernels are compiled.
    """
    NOTICE.has_spoken = has_spoken
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
