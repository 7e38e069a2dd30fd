"""A server of the page, in a thread."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import pytest

from hazbot_gym.live.policies import Policies
from hazbot_gym.live.settings import Settings


@pytest.fixture(scope="session")
def address() -> Iterator[str]:
    """Return the address of the page of a server that runs."""
    server = pytest.importorskip("hazbot_gym.live.server", reason="needs the extra live")
    policies = Policies("constant:0")
    for policy in ("idm", "velocity_obstacle"):  # compiled now, not while a page waits
        server.warm_up(policies, Settings(policy=policy, ghost="ppo"))
    with server.listen(0) as listening:
        live = server.Live(policies, listening.getsockname()[1])
        running = server.server_of(live)
        thread = threading.Thread(target=running.run, kwargs={"sockets": [listening]})
        thread.start()
        while not running.started:
            time.sleep(0.01)
        yield server.address(live, listening, "")
        running.should_exit = True
        thread.join()
