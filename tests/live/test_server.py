"""The server is for programs of this machine that know its address, and for no others."""

from __future__ import annotations

import http.client
import json
import threading
from contextlib import closing
from typing import Any, NamedTuple
from urllib.parse import urlsplit

import pytest

pytest.importorskip("hazbot_gym.live.server", reason="needs the extra live")

from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect

from hazbot_gym.live import launch, server, session
from hazbot_gym.live.settings import Settings
from tests.refusals import refused, says


class Answer(NamedTuple):
    status: int
    headers: Any
    text: str


def get(address: str, path: str, **headers: str) -> Answer:
    site = urlsplit(address)
    connection = http.client.HTTPConnection(site.hostname or "", site.port)
    with closing(connection):
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        return Answer(answer.status, answer.headers, answer.read().decode())


def page(address: str, origin: str | None = None) -> ClientConnection:
    site = urlsplit(address)
    socket = f"ws://{site.netloc}{site.path}socket"
    return connect(socket, origin=origin or f"http://{site.netloc}")  # type: ignore[arg-type]


def messages_of(socket: ClientConnection, kind: str, count: int = 1) -> list[Any]:
    """Return the next messages of a kind."""
    found: list[Any] = []
    while len(found) < count:
        message = json.loads(socket.recv(timeout=60))
        if message["kind"] == kind:
            found.append(message)
    return found


def test_files_are_served_below_the_token_only(address: str) -> None:
    path = urlsplit(address).path
    found = get(address, path)
    assert found.status == 200
    assert "main.js" in found.text
    assert get(address, path + "main.js").status == 200
    for other in ("/", "/index.html", "/main.js", "/wrong/", path + "../settings.py"):
        assert get(address, other).status == 404


def test_the_page_may_load_nothing_from_elsewhere(address: str) -> None:
    headers = get(address, urlsplit(address).path).headers
    assert headers["Content-Security-Policy"].startswith("default-src 'self'")
    assert headers["Referrer-Policy"] == "no-referrer"
    for file in server.STATIC.iterdir():
        text = file.read_text(encoding="utf-8").replace("http://www.w3.org/", "")
        assert "http:" not in text
        assert "https:" not in text


def test_another_host_name_is_refused(address: str) -> None:
    assert get(address, urlsplit(address).path, Host="evil.example").status == 400


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1"])
def test_a_page_of_another_site_cannot_connect(address: str, origin: str) -> None:
    with pytest.raises(InvalidStatus) as caught, page(address, origin):
        pass
    assert caught.value.response.status_code == 403


def test_without_the_token_nothing_connects(address: str) -> None:
    wrong = address.replace(urlsplit(address).path, "/wrong/")
    with pytest.raises(InvalidStatus), page(wrong):
        pass


def test_a_page_is_greeted_and_its_run_plays(address: str) -> None:
    with page(address) as socket:
        (hello,) = messages_of(socket, "hello")
        assert {"you", "fuzzy_expert", "ppo"} <= {choice["name"] for choice in hello["policies"]}
        settings = Settings(policy="constant:1", people=0).model_dump()
        socket.send(json.dumps({"kind": "configure", "settings": settings}))
        socket.send(json.dumps({"kind": "play", "is_playing": True, "rate": 4.0}))
        frames = messages_of(socket, "frame", 10)
    decisions = [frame["decision"] for frame in frames]
    assert decisions == list(range(10))
    assert frames[-1]["speed"] > 0.3


def test_what_is_no_message_is_answered_by_a_line_and_the_page_goes_on(address: str) -> None:
    with page(address) as socket:
        for text in ("{", '{"kind": "eval", "code": "1"}', '{"kind": "throttle", "share": 7}'):
            socket.send(text)
            (line,) = messages_of(socket, "line")
            assert line["is_error"]
        socket.send('{"kind": "step"}')
        (frame,) = messages_of(socket, "frame")
        assert frame["decision"] == 1


def test_a_run_goes_on_while_others_are_measured(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    may_end = threading.Event()

    def slow(*_: object, **__: object) -> list[dict[str, float]]:
        may_end.wait(60)
        return [{"return": 1.0}] * 10

    monkeypatch.setattr(session, "evaluate", slow)
    with page(address) as socket:
        socket.send('{"kind": "compare"}')
        socket.send('{"kind": "step"}')
        (frame,) = messages_of(socket, "frame")
        assert frame["decision"] == 1
        may_end.set()
        (scores,) = messages_of(socket, "scores")
    assert scores["returns"]["fuzzy_expert"] == [1.0] * 10


def test_too_many_pages_are_refused_with_a_line(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "MOST_PAGES", 1)
    with page(address) as first, page(address) as second:
        messages_of(first, "hello")
        (line,) = messages_of(second, "line")
        says(line["text"], "pages open already")


def test_a_port_in_use_is_refused_in_a_line() -> None:
    with server.listen(0) as taken:
        port = taken.getsockname()[1]
        with refused(f"port: {port} is in use"):
            server.listen(port)


def test_a_link_is_read_again() -> None:
    settings = Settings(env="Doorway-v1", episode=3, policy="idm", width_m=2.0, unyielding=0.5)
    link = launch.link_of(settings)
    for text in (link, f"http://127.0.0.1:8765/secret/?{link}"):
        assert launch.settings_of(text) == settings
    assert launch.settings_of(link, env="Aisle-v1").env == "Aisle-v1"
    for bad, said in (("episode=x", "episode"), ("place=x", "place: unknown key")):
        with refused(said):
            launch.settings_of(bad)
