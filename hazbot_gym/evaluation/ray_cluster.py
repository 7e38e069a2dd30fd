"""Pool of workers on a Ray cluster: a call is a Ray task on one core.

Ray distributes the tasks and repeats those whose worker or machine was lost; results return to this
process, which alone writes files. Ray trusts its network: tasks are pickles, and whoever reaches a
cluster's ports can run code on it.
"""

from __future__ import annotations

import functools
import logging
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hazbot_gym.errors import HazbotError, InvalidInput, MissingExtra
from hazbot_gym.evaluation import input_bundle, mirrored_folder
from hazbot_gym.evaluation.workers import RETRIES, Call, Outcome, leave_messages_to_parent

try:
    import ray
    from ray.exceptions import RayError, RayTaskError
    from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy
except ImportError as error:
    raise MissingExtra(error.name or "ray", "cluster") from error

Reference = Any  # of an object in Ray's store


class RayPool:
    """Pool of a connected cluster."""

    def __init__(self, files: Iterable[Path]) -> None:
        self._bundle = [ray.put(input_bundle.pack(files))]  # in a list Ray passes it unread
        on_a_core = ray.remote(num_cpus=1, max_retries=RETRIES)
        self._call, self._call_in = on_a_core(_call), on_a_core(_call_in)
        here = NodeAffinitySchedulingStrategy(ray.get_runtime_context().get_node_id(), soft=False)
        self._folders = (
            ray.remote(_Folders)
            .options(
                num_cpus=0, max_restarts=RETRIES, max_task_retries=RETRIES, scheduling_strategy=here
            )
            .remote()
        )
        self._running: set[Outcome] = set()
        self._is_open = True

    def submit(self, function: Call, /, *arguments: object) -> Outcome:
        """Call a function on a worker and return its future result."""
        self._check()
        return self._future(self._call.remote(self._bundle, function, arguments))

    def submit_in(self, folder: Path, function: Call, /, *arguments: object) -> Outcome:
        """Call a function on a worker with a copy of a folder of this machine."""
        self._check()
        original = os.path.abspath(folder)
        return self._future(
            self._call_in.remote(self._bundle, self._folders, original, function, arguments)
        )

    def close(self) -> None:
        """Cancel what is unfinished, so that nothing waits for it."""
        self._is_open = False
        for future in list(self._running):
            future.cancel()

    def _check(self) -> None:
        """Raise RuntimeError once closed; Ray would start a cluster of its own."""
        if not self._is_open:
            raise RuntimeError("the pool is closed")

    def _future(self, reference: Reference) -> Outcome:
        future: Outcome = reference.future()
        self._running.add(future)
        future.add_done_callback(self._running.discard)
        return future


@contextmanager
def connected(address: str, files: Iterable[Path]) -> Iterator[RayPool]:
    """Context manager of a cluster's pool; a connection that this process has is used.

    Raises:
        InvalidInput: There is no cluster at the address.
        HazbotError: Workers are lost again and again.
    """
    is_own = not ray.is_initialized()
    if is_own:
        _connect(address)
    pool = RayPool(files)
    try:
        yield pool
    except RayTaskError as error:  # raised by the function
        raise error.cause from None
    except RayError as error:
        said = str(error).partition("\n")[0]
        raise HazbotError(f"cluster: {said} Run again to go on.") from error
    finally:
        pool.close()
        if is_own:
            ray.shutdown()


def _connect(address: str) -> None:
    if address.startswith("ray://"):
        raise InvalidInput(
            f"cluster: given {address!r}, a client's address; run the command on a machine of the "
            "cluster, with 'auto'"
        )
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")  # else Ray warns of its future
    if address != "local":  # where nothing answers, Ray would try for minutes
        os.environ.setdefault("RAY_gcs_server_port_wait_time_s", "1")
    try:
        ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
    except (ConnectionError, ValueError, RuntimeError) as error:
        said = " ".join(str(error).split())
        raise InvalidInput(f"cluster: no connection to {address!r}: {said}") from error


def _call(bundle: list[Reference], function: Call, arguments: tuple[object, ...]) -> object:
    """Call a function in a worker."""
    _settle(*bundle)
    return function(*arguments)


def _call_in(
    bundle: list[Reference],
    folders: Any,
    original: str,
    function: Call,
    arguments: tuple[object, ...],
) -> object:
    """Call a function in a worker, in a copy of a folder of the driver's machine."""
    _settle(*bundle)
    contents = ray.get(folders.read.remote(original))

    def send(changes: mirrored_folder.Changes) -> None:
        ray.get(folders.apply.remote(original, changes))

    with mirrored_folder.working_copy(Path(original).name, contents, send) as folder:
        return function(folder, *arguments)


@functools.cache
def _settle(bundle: Reference) -> object:
    """Prepare a worker process, once: check versions and unpack the input files."""
    leave_messages_to_parent()
    return input_bundle.unpack(ray.get(bundle))


class _Folders:
    """Actor on the driver's machine, which gives workers access to folders there."""

    def read(self, folder: str) -> mirrored_folder.Contents:
        return mirrored_folder.read(Path(folder))

    def apply(self, folder: str, changes: mirrored_folder.Changes) -> None:
        mirrored_folder.apply(Path(folder), changes)
