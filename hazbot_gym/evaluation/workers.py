"""Places where work runs: this process, local worker processes, or a Ray cluster.

Work is submitted to a ``Pool``. Local worker processes start the same way on every system and end
with their parent; ``ray_cluster.py`` has the pool of a cluster.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from hazbot_gym.core.compile_message import COMPILE_MESSAGE
from hazbot_gym.errors import DoubtfulPlace, DoubtfulRecording, HazbotError

SAFE_PATH = "PYTHONSAFEPATH"
RETRIES = 10  # of a call whose worker, or its machine, was lost on a cluster


Call = Callable[..., Any]  # an importable function
Outcome = Future[Any]  # of a call


class Pool(Protocol):
    """Workers that accept calls of importable functions."""

    def submit(self, function: Call, /, *arguments: object) -> Outcome:
        """Call a function and return its future result."""
        ...

    def submit_in(self, folder: Path, function: Call, /, *arguments: object) -> Outcome:
        """Call a function with a folder of this machine, in which it reads and writes files."""
        ...


class Here:
    """Pool without workers: calls run in this process, at once."""

    def submit(self, function: Call, /, *arguments: object) -> Outcome:
        """Call a function and return its result."""
        future: Outcome = Future()
        future.set_result(function(*arguments))
        return future

    def submit_in(self, folder: Path, function: Call, /, *arguments: object) -> Outcome:
        """Call a function with a folder."""
        return self.submit(function, folder, *arguments)


class Processes(ProcessPoolExecutor):
    """Pool of local processes, which use the folders of this machine directly."""

    def submit_in(self, folder: Path, function: Call, /, *arguments: object) -> Outcome:
        """Call a function with a folder."""
        return self.submit(function, folder, *arguments)


class Place(NamedTuple):
    """Place of work: local processes, or a Ray cluster if there is an address."""

    processes: int
    cluster: str | None = None

    def pool(self, files: Iterable[Path] = ()) -> AbstractContextManager[Pool]:
        """Context manager of a pool; ``files`` are the input files that its calls read."""
        if self.cluster is None:
            return processes(self.processes)
        from hazbot_gym.evaluation import ray_cluster

        return ray_cluster.connected(self.cluster, files)


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
def processes(count: int) -> Iterator[Processes]:
    """Context manager of a process pool; tasks still queued at exit are cancelled.

    An error or an interrupt in the context ends them at once.

    Raises:
        HazbotError: One of them was ended from outside.
    """
    # Spawned processes start from nothing, the same way on every system.
    with _safe_path():
        yield from _processes(multiprocessing.get_context("spawn"), count)


def _processes(spawn: SpawnContext, count: int) -> Iterator[Processes]:
    listening, alive = spawn.Pipe(duplex=False)
    begin = (listening, COMPILE_MESSAGE.has_spoken)
    pool = Processes(count, mp_context=spawn, initializer=_begin, initargs=begin)
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
    they would finish their tasks beside the workers of a resumed run.
    """
    leave_messages_to_parent(has_spoken)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with, args=(listening,), daemon=True).start()


def leave_messages_to_parent(has_spoken: bool = True) -> None:
    """Silence the compile message, and warnings about places and recordings."""
    COMPILE_MESSAGE.has_spoken = has_spoken
    for said in (DoubtfulPlace, DoubtfulRecording):
        warnings.simplefilter("ignore", said)


def _end_with(listening: Connection) -> None:
    listening.poll(None)  # nothing is ever sent: it returns when the other end is closed
    os._exit(1)
