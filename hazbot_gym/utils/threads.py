"""Lazy thread pool that restarts after forks and copies."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

Result = TypeVar("Result")


class Threads:
    """A pool of threads that survives forks and copies: neither takes running threads along."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._pool: ThreadPoolExecutor | None = None
        self._process = 0  # in which they run

    def submit(self, job: Callable[..., Result], *arguments: object) -> Future[Result]:
        """Have a thread do a job."""
        if self._pool is None or self._process != os.getpid():
            self._pool, self._process = ThreadPoolExecutor(self._count), os.getpid()
        return self._pool.submit(job, *arguments)

    def close(self) -> None:
        """Stop the threads of this process; idempotent."""
        if self._pool is not None and self._process == os.getpid():
            self._pool.shutdown()
        self._pool = None

    def __getstate__(self) -> dict[str, object]:
        """Return the picklable state, without the threads."""
        return {**self.__dict__, "_pool": None}
