"""A running server, and browsers that are none: who gets a session, with what, and what nobody gets."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import quote

import msgspec
import pytest
import viser
import websockets.asyncio.server
from headless import CAMERA, PROTOCOL
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from ido_viz.app import App
from ido_viz.core.state import State, encode
from ido_viz.serving import server as serving
from ido_viz.serving import values
from ido_viz.serving.guests import Guests
from ido_viz.serving.listening import listen
from ido_viz.serving.room import Room
from ido_viz.serving.traffic import BURST, LARGEST, RATE, is_used
from ido_viz.teach.lessons import lesson

PATIENCE = 20.0  # seconds; only a failing test waits that long

BEGIN = State(playing=False)


@pytest.fixture(scope="module")
def app() -> Iterator[App]:
    app = App(BEGIN, port=0)
    yield app
    app.stop()


@pytest.fixture(scope="module")
def open_app() -> Iterator[App]:
    app = App(BEGIN, port=0, host="0.0.0.0")
    yield app
    app.stop()


def browser(app: App, query: str = "", **settings: Any) -> Connection:
    """A connection as a browser makes it, when all others are gone."""
    wait("no other page", lambda: app.n_sessions == 0)
    place = f"ws://127.0.0.1:{app.server.get_port()}/{query}"
    return connect(place, subprotocols=[PROTOCOL], compression=None, max_size=None, **settings)


def send(connection: Connection, **message: Any) -> None:
    connection.send(msgspec.msgpack.encode(message))


def wait(what: str, until: Callable[[], object]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not until():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.01)


def begun(app: App, query: str = "") -> State:
    """The state that a page's session begins with."""
    with browser(app, query) as connection:
        send(connection, **CAMERA)
        wait("a session", lambda: app.n_sessions == 1)
        (session,) = app._sessions.values()
        return session._state


# The address


def test_a_page_begins_with_the_state_of_its_address(app: App):
    state = State(left="ICP, tuned", playing=False, iteration=3)
    assert begun(app) == BEGIN
    assert begun(app, f"?fragment={quote(f'state={encode(state)}')}") == state


def test_a_page_begins_with_the_lesson_of_its_address(app: App):
    steps = lesson("histogram").steps
    assert begun(app, f"?fragment={quote('lesson=histogram')}") == steps[0].state
    assert begun(app, f"?fragment={quote('lesson=histogram/3')}") == steps[2].state


@pytest.mark.parametrize(
    "fragment",
    [
        "state=ido1-damaged",
        "state=<img src=x onerror=alert(1)>",
        f"state={encode(State(left='ICP'))}",
        "lesson=none such",
        "lesson=histogram/99",
        "lesson=histogram/-1",
        "state=" + "a" * 2500,
        "\x00",
    ],
)
def test_a_bad_address_begins_with_the_defaults(app: App, fragment: str):
    assert begun(app, f"?fragment={quote(fragment)}") == BEGIN


# Strangers


@pytest.mark.parametrize(
    "headers", [{"Origin": "http://evil.example"}, {"Origin": "null"}, {"Host": "evil.example:8080"}]
)
def test_other_pages_get_neither_a_session_nor_a_page(app: App, headers: dict[str, str]):
    host = {"Host": f"127.0.0.1:{app.server.get_port()}"} | headers
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(urllib.request.Request(app.url, headers=host), timeout=10)
    if "Host" not in headers:  # this client writes its own
        with pytest.raises(InvalidStatus, match="403"), browser(app, additional_headers=headers) as connection:
            send(connection, **CAMERA)


def test_our_own_page_connects(app: App):
    with browser(app, additional_headers={"Origin": app.url}) as connection:
        send(connection, **CAMERA)
        wait("a session", lambda: app.n_sessions == 1)


def test_a_page_for_others_needs_its_token_for_the_page_and_for_the_connection(open_app: App):
    token = open_app.url.partition("?")[2]
    assert token.startswith("token=") and len(token) > 20
    place = f"http://127.0.0.1:{open_app.server.get_port()}/"
    for query in ("", "?token=wrong"):
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(place + query, timeout=10)
        assert "Open the whole address that ido-viz printed" in refused.value.read().decode()
        with pytest.raises(InvalidStatus, match="403"):
            browser(open_app, query)
    assert urllib.request.urlopen(open_app.url, timeout=10).status == 200
    assert begun(open_app, f"?{token}") == BEGIN


def test_the_token_can_be_done_without():
    app = App(port=0, host="0.0.0.0", token=False)
    try:
        assert "token" not in app.url
        assert urllib.request.urlopen(app.url, timeout=10).status == 200
    finally:
        app.stop()


def test_the_page_is_the_same_packed_or_not_and_has_our_script_before_viser_s(app: App):
    plain = urllib.request.urlopen(app.url, timeout=10).read()
    packed = urllib.request.Request(app.url, headers={"Accept-Encoding": "gzip"})
    with urllib.request.urlopen(packed, timeout=10) as answer:
        assert answer.headers["Content-Encoding"] == "gzip"
    assert 0 < plain.index(b"hashchange") < plain.index(b"<script data-p")
    assert plain.index(b"<body>") < plain.index(b'id="ido-splash"') < plain.index(b'<div id="root">')
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"{app.url}/../secrets", timeout=10)


# What browsers may send


def test_nobody_gets_a_tunnel_and_no_message_is_kept_for_others(app: App, monkeypatch: pytest.MonkeyPatch):
    asked: list[str] = []
    for name in ("request_share_url", "disconnect_share_url"):
        monkeypatch.setattr(app.server, name, lambda *_, name=name, **__: asked.append(name))
    kept = len(app.server._websock_server.get_message_buffer().message_from_id)
    with browser(app) as connection:
        send(connection, type="ShareUrlRequest")
        send(connection, type="ShareUrlDisconnect")
        for number in range(200):
            send(connection, type="GuiFormDirtyMessage", uuid=f"form-{number}")
        send(connection, type="RunJavascriptMessage", source="alert(1)")
        send(connection, type="NoSuchMessage")
        connection.send(b"\xc1 nothing at all")
        connection.send("text")
        send(connection, **CAMERA)  # it still is a browser as any other
        wait("a session", lambda: app.n_sessions == 1)
    assert asked == []
    assert len(app.server._websock_server.get_message_buffer().message_from_id) == kept


def test_of_a_widget_only_the_value_can_be_changed():
    def update(**updates: object) -> bytes:
        return msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": "1", "updates": updates})

    assert is_used(update(value=3))
    assert not is_used(update(sync_cb=None))
    assert not is_used(update(value=3, removed=True))


def test_a_flood_has_to_wait(app: App):
    with browser(app) as connection:
        start = time.monotonic()
        for _ in range(BURST + RATE):
            send(connection, type="NoSuchMessage")
        send(connection, **CAMERA)
        wait("a session", lambda: app.n_sessions == 1)
        assert time.monotonic() - start > 0.9


def test_a_message_that_is_too_large_ends_the_connection(app: App):
    with browser(app) as connection:
        connection.send(os.urandom(LARGEST + 1))
        with pytest.raises(ConnectionClosed) as closed:
            while True:
                connection.recv(timeout=PATIENCE)
        assert closed.value.rcvd is not None and closed.value.rcvd.code == 1009


@pytest.mark.filterwarnings("ignore:.* does not match annotation")
def test_nonsense_is_not_written_to_the_terminal(app: App, caplog: pytest.LogCaptureFixture):
    for sent in (b"", b"junk\r\n\r\n", b"GET /" + b"a" * 10_000 + b" HTTP/1.1\r\n\r\n"):
        with socket.create_connection(("127.0.0.1", app.server.get_port())) as stranger:
            stranger.settimeout(PATIENCE)
            with contextlib.suppress(ConnectionError):
                stranger.sendall(sent)
                while sent and stranger.recv(1000):  # until it is hung up
                    pass
    with browser(app) as connection:
        send(connection, type="ViewerCameraMessage", wxyz="nothing else")
        with pytest.raises(ConnectionClosed):
            while True:
                connection.recv(timeout=PATIENCE)
    assert caplog.records == []


# The door


def test_other_servers_of_the_process_are_made_as_ever(app: App):
    assert websockets.asyncio.server.serve.__module__ == "websockets.asyncio.server"


def test_a_viser_that_serves_in_another_way_is_not_let_run_without_our_door(monkeypatch: pytest.MonkeyPatch):
    stopped: list[bool] = []

    class Otherwise:
        def __init__(self, **_: object) -> None: ...

        def stop(self) -> None:
            stopped.append(True)

    monkeypatch.setattr(viser, "ViserServer", Otherwise)
    with listen("127.0.0.1", 0) as listener, pytest.raises(RuntimeError, match="does not serve as it is known to"):
        serving.start(listener, Guests(), Room(1), "IDO Explorer")
    assert stopped == [True]


# Threads


def test_whoever_waits_for_a_page_is_woken_on_the_loop_s_thread_alone(app: App):
    """An event of asyncio's own walks through those who wait on any thread, while the loop changes who they are."""
    with browser(app) as connection:
        send(connection, **CAMERA)
        wait("a session", lambda: app.n_sessions == 1)
        (client,) = app.server.get_clients().values()
        buffer = client._websock_connection.get_message_buffer()
    kind: Any = type(buffer.message_event)
    assert buffer.message_event.loop is buffer.event_loop  # type: ignore[attr-defined]

    async def seen() -> list[tuple[bool, bool]]:
        event = kind()
        event.loop = asyncio.get_running_loop()
        waiting = asyncio.ensure_future(event.wait())
        await asyncio.sleep(0)
        stages = []
        for set_it in (lambda: asyncio.to_thread(event.set), lambda: asyncio.sleep(0, event.set())):
            await set_it()
            await asyncio.sleep(0.05)
            stages.append((event.is_set(), waiting.done()))
        return stages

    with ThreadPoolExecutor() as thread:  # this one may have a loop already
        assert thread.submit(asyncio.run, seen()).result() == [(True, False), (True, True)]


# Numbers that are typed


class Typed:
    """A slider of a page, what a browser writes into it, and what it is told."""

    def __init__(self, app: App, connection: Any, label: str, monkeypatch: pytest.MonkeyPatch) -> None:
        send(connection, **CAMERA)
        wait("a session", lambda: app.n_sessions == 1)
        (client,) = app.server.get_clients().values()
        widgets: dict[str, Any] = client.gui._gui_input_handle_from_uuid
        wait("the slider", lambda: any(each.label == label for each in list(widgets.values())))
        self.widget = next(each for each in list(widgets.values()) if each.label == label)
        self._connection, self._uuid = connection, self.widget._impl.uuid
        self._told: list[Any] = []
        interface = client.gui._websock_interface
        queue = interface.queue_message
        monkeypatch.setattr(interface, "queue_message", lambda message: (self._told.append(message), queue(message)))

    def write(self, *values: float) -> None:
        for value in values:
            send(self._connection, type="GuiUpdateMessage", uuid=self._uuid, updates={"value": value})

    @property
    def answers(self) -> list[float]:
        return [each.updates["value"] for each in list(self._told) if getattr(each, "uuid", "") == self._uuid]

    @property
    def complaints(self) -> list[str]:
        return [each.props.body for each in list(self._told) if type(each).__name__ == "NotificationShowMessage"]


def test_a_number_is_told_once_more_when_its_widget_is_at_rest(app: App, monkeypatch: pytest.MonkeyPatch):
    """What the server wrote at the same time would stand in the browser's field for good."""
    monkeypatch.setattr(values, "AT_REST", 0.2)
    with browser(app) as connection:
        noise = Typed(app, connection, "Noise", monkeypatch)
        noise.write(0.06, 0.07)
        wait("the last value, once more", lambda: noise.answers == [0.07])


def test_a_number_that_is_still_typed_is_neither_answered_nor_complained_about(
    app: App, monkeypatch: pytest.MonkeyPatch
):
    """The 2 of 2000 is no number of points yet."""
    monkeypatch.setattr(values, "AT_REST", 0.5)
    with browser(app) as connection:
        points = Typed(app, connection, "Points", monkeypatch)
        points.write(2, 20, 200, 2000)
        wait("the number at rest", lambda: points.answers == [2000])
        assert points.complaints == [] and points.widget.value == 2000
        points.write(2)
        wait("what is wrong", lambda: points.complaints != [])
        assert points.complaints == ["Points: 2 is too small; the least is 100. It is 100 now."]
        wait("the least", lambda: points.answers[-1] == points.widget.value == 100)


def test_a_number_that_is_too_large_becomes_the_largest_and_not_its_first_digit(
    app: App, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(values, "AT_REST", 0.2)
    with browser(app) as connection:
        rotation = Typed(app, connection, "Rotation", monkeypatch)
        rotation.write(5, 50, 500)
        wait("the largest", lambda: rotation.widget.value == 180 and rotation.answers[-1] == 180)
        wait("what is wrong", lambda: rotation.complaints != [])
        assert rotation.complaints == ["Rotation: 500 is too large; the most is 180. It is 180 now."]
        rotation.write(float("nan"))
        wait("what is wrong", lambda: len(rotation.complaints) == 2)
        assert rotation.widget.value == 180


def test_a_value_that_is_taken_wakes_nobody_but_its_page(app: App, monkeypatch: pytest.MonkeyPatch):
    """viser would pass it on to the other pages, of which a widget of one page has none."""
    monkeypatch.setattr(values, "AT_REST", 60.0)
    with browser(app) as connection:
        noise = Typed(app, connection, "Noise", monkeypatch)
        noise.write(0.06, 0.07, 0.08)
        wait("the last value", lambda: noise.widget.value == 0.08)
        assert noise.answers == []
