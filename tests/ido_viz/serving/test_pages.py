"""Pages of a running server, as a tab without a browser sees them: what they find, keep, and are refused."""

from __future__ import annotations

import asyncio
import gc
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import quote

import pytest
import viser
from headless import PROTOCOL, HeadlessTab, run
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from ido import Perturbation
from ido_viz.app import App
from ido_viz.core.state import State, encode
from ido_viz.page import Page

PATIENCE = 20.0  # seconds; only a failing test waits that long
BEGIN = State(playing=False)


@pytest.fixture(scope="module")
def its_app() -> Iterator[App]:
    app = App(BEGIN, port=0)
    yield app
    app.stop()


@pytest.fixture
def app(its_app: App) -> App:
    """An app that serves no page."""
    wait("no other page", lambda: its_app.n_sessions == 0)
    return its_app


def wait(what: str, until: Callable[[], object]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not until():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.01)


def test_a_page_that_comes_back_finds_what_was_computed_and_what_it_can_undo(app: App):
    name, other = f"?page={'a' * 32}", f"?page={'b' * 32}"

    async def visit(query: str, **changes: float) -> HeadlessTab:
        tab = HeadlessTab(f"{app.url}/{query}")
        await tab.open()
        for slider, value in changes.items():
            await tab.set(slider, value)
            await asyncio.sleep(1.2)  # changes that follow each other at once are undone at once
        return tab

    async def come_back() -> None:
        tab = await visit(name, Rotation=30, Noise=0.02)
        (session,) = app._sessions.values()
        state, run = session._state, session._run
        assert (state.perturbation.rotation, state.perturbation.noise) == (30, 0.02)
        await tab.close()
        await tab.until("the end of the thread", lambda: session.can_come_back)
        fragment = quote(f"state={encode(state)}")
        stranger = await visit(f"{other}&fragment={fragment}")
        assert session not in app._sessions.values()
        await stranger.close()
        tab = await visit(f"{name}&fragment={fragment}")
        await tab.until("the session", lambda: session in app._sessions.values())
        assert session._run is run
        await tab.push("Undo")
        await tab.until("the change before", lambda: session._state.perturbation == Perturbation(rotation=30))
        await tab.close()

    run(come_back())


def test_a_page_that_is_reloaded_in_mid_frame_finds_its_session(app: App, monkeypatch: pytest.MonkeyPatch):
    draw, name = Page.draw, "c" * 32

    def drawn_slowly(page: Page, *frame: Any, **options: Any) -> None:
        draw(page, *frame, **options)
        if slowly:
            drawing.set()
            time.sleep(0.5)

    slowly: list[bool] = []
    drawing = threading.Event()
    monkeypatch.setattr(Page, "draw", drawn_slowly)

    async def reload() -> None:
        tab = HeadlessTab(f"{app.url}/?page={name}")
        await tab.open()
        (session,) = app._sessions.values()
        slowly.append(True)
        await tab.set("Rotation", 40)
        await asyncio.to_thread(drawing.wait, PATIENCE)
        await tab.close()
        assert not session.can_come_back
        again = HeadlessTab(f"{app.url}/?page={name}")
        await again.open()
        assert list(app._sessions.values()) == [session]
        await again.close()

    run(reload())


def test_a_page_that_is_reloaded_while_the_server_is_at_work_finds_its_session(app: App):
    name = "d" * 32

    async def reload() -> None:
        tab = HeadlessTab(f"{app.url}/?page={name}")
        await tab.open()
        (session,) = app._sessions.values()
        for _ in range(64):  # clicks of a class, all at once
            app.server._thread_executor.submit(time.sleep, 0.3)
        await tab.close()
        again = HeadlessTab(f"{app.url}/?page={name}")
        await again.open()
        found = list(app._sessions.values())
        await again.close()
        assert found == [session]

    run(reload())


def test_a_page_whose_end_is_noticed_after_its_new_beginning_finds_its_session(monkeypatch: pytest.MonkeyPatch):
    at_once = App._close

    async def late(self: App, client: viser.ClientHandle) -> None:
        await asyncio.sleep(0.3)
        await at_once(self, client)

    monkeypatch.setattr(App, "_close", late)
    app = App(BEGIN, port=0)

    async def reload() -> None:
        tab = HeadlessTab(f"{app.url}/?page={'e' * 32}")
        await tab.open()
        (session,) = app._sessions.values()
        await tab.close()
        again = HeadlessTab(f"{app.url}/?page={'e' * 32}")
        await again.open()
        assert list(app._sessions.values()) == [session]
        await again.close()

    try:
        run(reload())
    finally:
        app.stop()


def test_a_tab_that_was_duplicated_has_a_session_of_its_own_beside_the_first(app: App):
    async def duplicate() -> None:
        tabs = [HeadlessTab(f"{app.url}/?page={'f' * 32}") for _ in range(2)]
        for tab in tabs:
            await tab.open()
        assert len(set(app._sessions.values())) == 2
        for tab in tabs:
            await tab.close()

    run(duplicate())


def test_a_page_that_is_left_in_mid_frame_leaves_no_warning(
    app: App, recwarn: pytest.WarningsRecorder, monkeypatch: pytest.MonkeyPatch
):
    draw = Page.draw

    def drawn_later(page: Page, *frame: Any, **options: Any) -> None:
        if leaving:
            wait("the end of the connection", lambda: app.n_sessions == 0)
        draw(page, *frame, **options)

    leaving: list[bool] = []
    before = set(threading.enumerate())  # other tests' pages are open, too
    monkeypatch.setattr(Page, "draw", drawn_later)
    gc.collect()  # what other tests left has its warnings now
    recwarn.clear()

    async def visit() -> None:
        tab = HeadlessTab(app.url)
        await tab.open()
        leaving.append(True)
        await tab.set("Rotation", 40)
        await asyncio.sleep(0.2)
        await tab.close()

    run(visit())
    sessions = [t for t in set(threading.enumerate()) - before if t.name.startswith("session-")]
    wait("the end of the sessions", lambda: not [t for t in sessions if t.is_alive()])
    gc.collect()  # or what this one left has them later
    assert [str(warning.message) for warning in recwarn] == []


def test_the_charts_of_a_tab_are_made_when_it_is_opened_and_not_before(app: App):
    async def visit() -> None:
        tab = HeadlessTab(app.url)
        await tab.open()
        await tab.until("two histograms", lambda: len(tab.charts) == 2)
        frames = tab.counts.frames
        await tab.set("Rotation", 20)
        await tab.until("a frame", lambda: tab.counts.frames > frames)
        assert len(tab.charts) == 2
        await tab.set("Open tabs", "Scene,Histograms,Errors")
        await tab.until("the curves of the errors", lambda: len(tab.charts) == 2 + 4)
        await tab.close()

    run(visit())


def test_a_value_that_is_not_on_offer_is_refused_and_the_page_goes_on(app: App):
    async def visit() -> None:
        tab = HeadlessTab(app.url)
        await tab.open()
        for label, value in (("Sort by", "beauty"), ("Shape", "cow"), ("Left pane", 7), ("Order bins by", None)):
            await tab.set(label, value)
            await tab.until("the message", lambda label=label: any(label in note for note in tab.notes))
        frames = tab.counts.frames
        await tab.set("Rotation", 30)
        await tab.until("a frame", lambda: tab.counts.frames > frames)
        await tab.close()
        assert all("is not on offer; choose from the list." in note for note in tab.notes)

    run(visit())


def test_for_whom_there_is_no_room_gets_a_friendly_page_until_somebody_leaves():
    app = App(BEGIN, port=0, sessions=2)

    def page() -> int:
        try:
            return urllib.request.urlopen(app.url, timeout=10).status
        except urllib.error.HTTPError as error:
            assert "goes on as soon as\nsomebody closes theirs" in error.read().decode()
            return error.code

    place = f"ws://127.0.0.1:{app.server.get_port()}/"
    try:
        with connect(place, subprotocols=[PROTOCOL]), connect(place, subprotocols=[PROTOCOL]):
            assert page() == 503
            with pytest.raises(InvalidStatus, match="503"):
                connect(place, subprotocols=[PROTOCOL])
        wait("room", lambda: page() == 200)
    finally:
        app.stop()
