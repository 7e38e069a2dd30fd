"""Worker processes that start the same way on every system and end with their parent."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext

from hazbot_gym.core.compile_message import COMPILE_MESSAGE
from hazbot_gym.errors import DoubtfulPlace, DoubtfulRecording, HazbotError

SAFE_PATH = "PYTHONSAFEPATH"


@contextmanager
def _safe_path() -> Iterator[None]:
    """Keep the working folder off the search path of processes that Python starts.

    Otherwise its files would shadow Python's own modules until a worker has its parent's search
    path.
    """
    before = os.environ.get(SAFE_PATH)
    os.environ[SAFE_PATH] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[SAFE_PATH]
        else:
            os.environ[SAFE_PATH] = before


@contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor]:
    """Context manager of a process pool; tasks still queued at exit are cancelled.

    An error or an interrupt in the context ends them at once.

    Raises:
        HazbotError: One of them was ended from outside.
    """
    # Spawned processes start from nothing, the same way on every system.
    with _safe_path():
        yield from _processes(multiprocessing.get_context("spawn"), count)


def _processes(spawn: SpawnContext, count: int) -> Iterator[ProcessPoolExecutor]:
    listening, alive = spawn.Pipe(duplex=False)
    begin = (listening, COMPILE_MESSAGE.has_spoken)
    pool = ProcessPoolExecutor(count, mp_context=spawn, initializer=_begin, initargs=begin)
    try:
        yield pool
    except BrokenProcessPool as error:
        raise HazbotError("a worker process was ended from outside; run again to go on") from error
    except BaseException:  # Ctrl-C, a full disk: do not wait for unfinished tasks
        alive.close()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        alive.close()
        listening.close()


def _begin(listening: Connection, has_spoken: bool) -> None:
    """End a worker quietly on Ctrl-C, and at once when its parent or its pool ends.

    A killed parent cannot notify its workers, but the system closes its end of the pipe; otherwise
    they would finish their tasks beside the workers of a resumed run. Warnings about places and
    recordings, and the compile message, are left to the parent.
    """
    COMPILE_MESSAGE.has_spoken = has_spoken
    for said in (DoubtfulPlace, DoubtfulRecording):
        warnings.simplefilter("ignore", said)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with, args=(listening,), daemon=True).start()


def _end_with(listening: Connection) -> None:
    listening.poll(None)  # nothing is ever sent: it returns when the other end is closed
    os._exit(1)
