"""A server of the page, in a thread, and a policy that observes the price of nearness."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

from hazbot_gym.live.policies import Policies
from hazbot_gym.live.settings import Settings
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import describe, write
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.price_input import PriceInput


@pytest.fixture(scope="session")
def priced(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return the spec of a policy that stops at high prices."""
    path = tmp_path_factory.mktemp("priced") / "policy.npz"
    weight = np.zeros((52, 1), np.float32)
    weight[-1] = -1.0
    actor = Actor((Layer(weight, np.zeros(1, np.float32)),), "tanh", "clipped")
    prices = PriceInput(1.0, 16.0, 4.0)
    with path.open("wb") as file:
        write(describe(actor, algorithm="PPO", tier="tracks", prices=prices), file)
    return f"learned:{path}"


@pytest.fixture(scope="session")
def address(priced: str) -> Iterator[str]:
    """Return the address of the page of a server that runs."""
    server = pytest.importorskip("hazbot_gym.live.server", reason="needs the extra live")
    policies = Policies("constant:0", priced)
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
