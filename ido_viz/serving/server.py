"""viser's server behind a door of our own.

viser makes its web server in one call of `websockets.asyncio.server.serve`, and that call is all we change: while a
viser server is made, ours stands in its place. It hands on everything, with a socket that listens already, looks at
each request before viser sees it, remembers it for `current_request`, bounds what browsers send, and serves viser's
page with scripts in it: `charts.js` for the data of charts, `address.js` for the address, and `page.js` for what
viser's page lacks; `splash.html` stands before it until there is something to see.
"""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import http
import logging
import socket
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import viser
import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from ido_viz.serving.guests import Guests
from ido_viz.serving.room import FULL, Room
from ido_viz.serving.traffic import LARGEST, BoundedConnection

_PAGES = ("/", "/index.html")
_SCRIPTS = ("charts.js", "address.js", "page.js")
_REQUEST: ContextVar[Request] = ContextVar("request")
_one_at_a_time = threading.Lock()

_nonsense = logging.getLogger(f"{__name__}.nonsense")
_nonsense.setLevel(logging.CRITICAL)  # strangers must not be able to fill the terminal with what they send


def current_request() -> Request:
    """The request that the running callback's browser connected with; for asynchronous callbacks of viser alone."""
    return _REQUEST.get()


def start(listener: socket.socket, guests: Guests, room: Room, label: str) -> viser.ViserServer:
    """A viser server on a socket that listens.

    Args:
        listener: taken over, and closed when the server stops.
        guests: who is answered.
        room: how many at once.
        label: of its panel.

    Raises:
        RuntimeError: this version of viser makes its server in another way.
    """
    host, port = listener.getsockname()[:2]
    with _our_door(listener, guests, room) as passed:
        server = viser.ViserServer(host=host, port=port, label=label, verbose=False)
    if not passed.is_set():
        server.stop()
        raise RuntimeError(f"viser {viser.__version__} does not serve as it is known to; install an older one")
    return server


class AnyThreadEvent(asyncio.Event):
    """An event that any thread may set; those who wait are woken when it is set on the thread of their loop.

    viser sets one on the threads that draw, and then on its own to wake who sends. asyncio's event, which is for one
    thread, also wakes from the others, and fails there when somebody begins to wait at the same moment.
    """

    loop: asyncio.AbstractEventLoop | None = None
    """On whose thread those are who wait."""

    _value = False  # as asyncio names it

    def set(self) -> None:
        """Set it."""
        self._value = True
        here = asyncio._get_running_loop()
        if here is None or here is not self.loop:
            return
        for waiting in self._waiters:
            if not waiting.done():
                waiting.set_result(True)


def prepare(client: viser.ClientHandle) -> None:
    """Make a connection ready to be drawn on by another thread, also in the moment when its page is closed."""
    buffer = client._websock_connection.get_message_buffer()
    event: Any = buffer.message_event
    event.__class__ = AnyThreadEvent  # who waits for it already goes on waiting
    event.loop = buffer.event_loop
    buffer._warned_push_after_done = True  # viser warns once of what is thrown away, and has now


@contextlib.contextmanager
def _our_door(listener: socket.socket, guests: Guests, room: Room) -> Iterator[threading.Event]:
    """While it lasts, a viser server that is made is served by us; the event says that one was."""
    passed = threading.Event()
    original = websockets.asyncio.server.serve

    def serve(handler: Callable[[ServerConnection], Awaitable[None]], *place: Any, **settings: Any) -> Any:
        if not handler.__module__.startswith("viser."):  # somebody else's server in this process
            return original(handler, *place, **settings)
        passed.set()
        serve_file = settings["process_request"]

        async def handle(connection: ServerConnection) -> None:
            assert connection.request is not None
            _REQUEST.set(connection.request)
            if room.is_full:  # others came in the meantime
                await connection.close(CloseCode.TRY_AGAIN_LATER, "full")
                return
            room.taken += 1
            try:
                await handler(connection)
            finally:
                room.taken -= 1

        def answer(connection: ServerConnection, request: Request) -> Response | None:
            refused = guests.refusal(request)
            if refused is not None:
                return connection.respond(http.HTTPStatus.FORBIDDEN, refused + "\n")
            is_socket = request.headers.get("Upgrade", "").lower() == "websocket"
            if room.is_full and (is_socket or urlsplit(request.path).path in _PAGES):
                return _full()
            if is_socket:
                return None
            if urlsplit(request.path).path in _PAGES:
                return _page(request)
            return serve_file(connection, request)

        ours = {
            "process_request": answer,
            "create_connection": BoundedConnection,
            "max_size": LARGEST,
            "logger": _nonsense,
        }
        return original(handle, sock=listener, **settings | ours)

    with _one_at_a_time:
        websockets.asyncio.server.serve = serve  # type: ignore[assignment]
        try:
            yield passed
        finally:
            websockets.asyncio.server.serve = original


def _full() -> Response:
    """What is answered when there is no room."""
    body = FULL.encode()
    headers = Headers(
        {"Content-Type": "text/html; charset=utf-8", "Content-Length": str(len(body)), "Retry-After": "10"}
    )
    return Response(http.HTTPStatus.SERVICE_UNAVAILABLE, "Full", headers, body)


def _page(request: Request) -> Response:
    """The page, packed if the browser takes that."""
    packs = "gzip" in request.headers.get("Accept-Encoding", "")
    body = _packed_page() if packs else gzip.decompress(_packed_page())
    headers = Headers({"Content-Type": "text/html; charset=utf-8", "Content-Length": str(len(body))})
    if packs:
        headers["Content-Encoding"] = "gzip"
    return Response(http.HTTPStatus.OK, "OK", headers, body)


@cache
def _packed_page() -> bytes:
    """viser's page with our scripts before its own, behind our splash."""
    page = (Path(viser.__file__).parent / "client/build/index.html").read_text("utf-8")
    here = Path(__file__).parent
    scripts = "".join(f"<script>{(here / name).read_text('utf-8')}</script>" for name in _SCRIPTS)
    before, head, rest = page.partition("<head>")
    between, body, after = rest.rpartition("<body>")  # viser's own script may name one
    splash = (here / "splash.html").read_text("utf-8")
    return gzip.compress("".join([before, head, scripts, between, body, splash, after]).encode())
