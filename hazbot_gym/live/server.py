"""The page and its server: files, and a WebSocket that carries one session.

Everything is below a path with a token, only programs of this machine can connect, and a page of
another site is refused by its Origin. No code and no file named by the page is run or read.
"""

from __future__ import annotations

import contextlib
import errno
import secrets
import socket
import time
from pathlib import Path

import anyio
import anyio.abc
import anyio.to_thread

from hazbot_gym.errors import HazbotError, InvalidInput, MissingExtra
from hazbot_gym.live import messages, view
from hazbot_gym.live.messages import MOST_BYTES, Received, Sent
from hazbot_gym.live.policies import Policies
from hazbot_gym.live.session import Session
from hazbot_gym.live.settings import Settings
from hazbot_gym.utils.whole_number import whole_number

try:
    import uvicorn
    import websockets  # noqa: F401  (uvicorn's WebSockets)
    from starlette.applications import Starlette
    from starlette.middleware import Middleware
    from starlette.middleware.trustedhost import TrustedHostMiddleware
    from starlette.responses import Response
    from starlette.routing import Mount, WebSocketRoute
    from starlette.staticfiles import StaticFiles
    from starlette.types import Scope
    from starlette.websockets import WebSocket, WebSocketDisconnect
except ImportError as error:
    raise MissingExtra("starlette, uvicorn or websockets", "live") from error

HOST = "127.0.0.1"
NAMES = (HOST, "localhost")
STATIC = Path(__file__).parent / "static"
MOST_PAGES = 20
TOO_MANY = f"this server has {MOST_PAGES} pages open already, and no more: close one"
REFUSED, BUSY = 1008, 1013  # closing codes of RFC 6455: policy, try again later
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'",
    "Referrer-Policy": "no-referrer",  # the address has the token
    "X-Content-Type-Options": "nosniff",
}


class Pages(StaticFiles):
    """The files of the page, with headers that keep it to itself."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Return a file."""
        response = await super().get_response(path, scope)
        response.headers.update(HEADERS)
        return response


class Live:
    """State that all pages of a server share.

    Attributes:
        token: Secret part of the address.
    """

    def __init__(self, policies: Policies, port: int, token: str | None = None) -> None:
        self.token = token or secrets.token_urlsafe(16)
        self._policies = policies
        self._origins = [f"http://{name}:{port}" for name in NAMES]
        self._open = 0

    def application(self) -> Starlette:
        """Return the web application."""
        return Starlette(
            routes=[
                WebSocketRoute(f"/{self.token}/socket", self._connect),
                Mount(f"/{self.token}", Pages(directory=STATIC, html=True)),
            ],
            middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=[*NAMES])],
        )

    async def _connect(self, socket: WebSocket) -> None:
        if socket.headers.get("origin") not in self._origins:
            await socket.close(REFUSED)  # before it is accepted: the page gets 403
            return
        await socket.accept()
        if self._open >= MOST_PAGES:
            await _send(socket, messages.Line(text=TOO_MANY, is_error=True))
            await socket.close(BUSY)
            return
        self._open += 1
        try:
            await Page(socket, self._policies).serve()
        finally:
            self._open -= 1


class Page:
    """One page that is open."""

    def __init__(self, socket: WebSocket, policies: Policies) -> None:
        self._socket, self._policies = socket, policies
        self._lock = anyio.Lock()  # a session does one thing at a time

    async def serve(self) -> None:
        """Serve the page until it closes."""
        with contextlib.suppress(WebSocketDisconnect):
            await _send(self._socket, view.hello(self._policies))
            self._session = await anyio.to_thread.run_sync(Session, self._policies)
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._play, tasks.cancel_scope)
                await self._listen(tasks)
                tasks.cancel_scope.cancel()

    async def _listen(self, tasks: anyio.abc.TaskGroup) -> None:
        """Answer the page's messages."""
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                text = await self._socket.receive_text()
                try:
                    message = messages.parse(text)
                except HazbotError as error:
                    line = messages.Line(text=str(error), is_error=True)
                    await _send(self._socket, line)
                    continue
                if isinstance(message, messages.Compare):  # takes seconds; the run goes on
                    tasks.start_soon(self._compare, message)
                else:
                    await self._answer(message)

    async def _answer(self, message: Received) -> None:
        async with self._lock:
            answers = await anyio.to_thread.run_sync(self._session.receive, message)
        for answer in answers:
            await _send(self._socket, answer)

    async def _compare(self, message: messages.Compare) -> None:
        with contextlib.suppress(WebSocketDisconnect):
            for answer in await anyio.to_thread.run_sync(
                self._session.receive, message, abandon_on_cancel=True
            ):
                await _send(self._socket, answer)

    async def _play(self, scope: anyio.CancelScope) -> None:
        """Take decisions in time while the session plays; what comes late is not caught up."""
        due = time.monotonic()
        try:
            while True:
                decision_s = self._session.run.env.episode_config.clock.decision_s
                due = max(due + decision_s / self._session.rate, time.monotonic())
                await anyio.sleep_until(anyio.current_time() + due - time.monotonic())
                if self._session.is_playing:
                    async with self._lock:
                        frames = await anyio.to_thread.run_sync(self._session.tick)
                    for frame in frames:
                        await _send(self._socket, frame)
        except WebSocketDisconnect:
            scope.cancel()


async def _send(socket: WebSocket, message: Sent) -> None:
    await socket.send_text(message.model_dump_json())


def listen(port: int) -> socket.socket:
    """Return a socket on a port of this machine; port 0 is any that is free.

    Raises:
        InvalidInput: The port is in use, or not allowed.
    """
    whole_number(port, "port", 0, 65535)
    made = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((HOST, port))
        made.listen()
    except OSError as error:
        made.close()
        if error.errno == errno.EADDRINUSE:
            raise InvalidInput(
                f"port: {port} is in use, perhaps by another hazbot play; give another, or 0 for "
                "any that is free"
            ) from error
        raise InvalidInput(f"port: given {port}: {error.strerror}") from error
    return made


def warm_up(policies: Policies, settings: Settings) -> None:
    """Take some decisions, so that what is compiled is compiled before a page opens.

    Raises:
        InvalidInput: The settings cannot be used.
    """
    session = Session(policies, settings)
    for _ in range(3):
        session.tick()


def server_of(live: Live) -> uvicorn.Server:
    """Return a server, which ``run(sockets=[...])`` starts."""
    config = uvicorn.Config(
        live.application(),
        log_level="warning",
        access_log=False,  # addresses have the token
        ws="websockets-sansio",
        ws_max_size=MOST_BYTES,
        lifespan="off",
        timeout_graceful_shutdown=1,
    )
    return uvicorn.Server(config)


def address(live: Live, on: socket.socket, link: str) -> str:
    """Return the page's address; ``link`` is the part of a link behind its question mark."""
    return f"http://{HOST}:{on.getsockname()[1]}/{live.token}/" + (f"?{link}" if link else "")
