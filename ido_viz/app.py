"""The server: one session for each browser tab."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from urllib.parse import parse_qs, quote, urlsplit

import viser
from websockets.http11 import Request

from ido.console import hush
from ido_viz.core.address import read_fragment
from ido_viz.core.keeping import Keeping
from ido_viz.core.library import Library, shipped_library
from ido_viz.core.state import State, StateError, decode
from ido_viz.own.draft import Draft
from ido_viz.own.workshop import Workshop
from ido_viz.serving.entrance import Entrance
from ido_viz.serving.guests import read_origins
from ido_viz.serving.listening import listen
from ido_viz.serving.room import Room, usual_room
from ido_viz.serving.server import current_request, prepare, start
from ido_viz.serving.values import refuse_nonsense
from ido_viz.session import Session
from ido_viz.teach.derivations import derivations
from ido_viz.teach.lessons import lessons, step_named
from ido_viz.teach.presets import presets

AWAY = 120.0
"""Seconds that a session is kept after its connection went."""

_LONGEST_GOODBYE = 1.0  # seconds in which a page that is reloaded is noticed to have left
_LONGEST_FRAME = 5.0  # seconds that a page which is reloaded in mid-frame waits for its end

_SHORTEST_NAME = 20


class App:
    """A running explorer.

    Args:
        state: what a new tab shows, if its address does not say.
        library: the shapes and methods on offer; the shipped ones unless given.
        host: address to listen on.
        port: port to listen on; 0 for any free one, None for the first free one from 8080 on.
        token: whether an address that other machines can open has a token, without which nobody is answered.
        origins: from where else a page of ours may come, as ``https://example.org`` of a proxy.
        sessions: how many pages are served at once; as many as suit the machine unless given.
        data: folder where people's own clouds are kept; None for pages without them.
        draft: a cloud of one's own that pages begin with, to be trained on there.
        entrance: that of another process, which hands pages on to this one. It alone is told the port, which is any
            free one, and the host, token and origins are its own.

    Raises:
        StateError: the state's shape or methods are not in the library.
        ContentError: a lesson, preset or derivation has a mistake.
        ListenError: the host or the port cannot be used.
        OriginError: an origin is not one.
    """

    def __init__(
        self,
        state: State | None = None,
        *,
        library: Library | None = None,
        host: str = "127.0.0.1",
        port: int | None = None,
        token: bool = True,
        origins: Collection[str] = (),
        sessions: int | None = None,
        data: Path | None = None,
        draft: Draft | None = None,
        entrance: Entrance | None = None,
    ) -> None:
        self._library = library or shipped_library()
        self._workshop = None if data is None else Workshop(self._library, data, draft)
        if self._workshop is not None:
            self._library = self._workshop.library
        self._state = self._library.checked(state or State())
        for load in (lessons, presets, derivations):
            load()  # a mistake in one is said here, not when a tab is opened
        self._sessions: dict[int, Session] = {}
        self._names: dict[int, str] = {}  # of their pages
        self._away = Keeping[Session](AWAY, Session.close)
        self._lock = threading.Lock()
        its_origins = read_origins(origins)
        listener = listen(host, port) if entrance is None else listen("127.0.0.1", 0)
        self.entrance = entrance or Entrance.of(listener, host, token=token, origins=its_origins)
        """Where pages come in."""
        with hush():  # the command prints the address itself
            self.server = start(listener, self.entrance.guests, Room(sessions or usual_room()), "IDO Explorer")
        self.server.scene.world_axes.visible = False
        self.server.on_client_connect(self._open)
        self.server.on_client_disconnect(self._close)

    @property
    def url(self) -> str:
        """Where the page really is, for those who may open it."""
        return self.entrance.url

    @property
    def unreadable(self) -> tuple[str, ...]:
        """Kept clouds that cannot be read, and why."""
        return () if self._workshop is None else self._workshop.shelf.unreadable

    @property
    def n_sessions(self) -> int:
        """How many tabs are open."""
        return len(self._sessions)

    def stop(self) -> None:
        """Close all tabs' sessions and stop listening."""
        with self._lock:
            sessions = list(self._sessions.values())
            self._sessions.clear()
        self._away.clear()
        for session in sessions:
            session.close()
        if self._workshop is not None:
            self._workshop.close()
        with hush():
            self.server.stop()

    async def _open(self, client: viser.ClientHandle) -> None:
        prepare(client)
        refuse_nonsense(
            client, lambda reason: client.add_notification("Not taken as it is", reason, auto_close_seconds=8.0)
        )
        request = current_request()
        if self._workshop is not None:
            await asyncio.to_thread(self._workshop.shelf.look_again)  # another page's cloud may just be written
        state, step, complaint = self._asked(request)
        name, address = _name(request), self._shown_address(request)
        await self._wait_until_left(name)
        session = self._away.take(name)
        if session is not None and await asyncio.to_thread(session.ends_within, _LONGEST_FRAME):
            session.come_back(client, state, address, step)
        else:
            if session is not None:  # still at the frame in which it was left
                session.close()
            session = Session(client, self._library, state, address, step, self._workshop)
        with self._lock:
            if client.client_id not in self.server.get_clients():  # gone again already
                session.close()
                return
            self._sessions[client.client_id] = session
            self._names[client.client_id] = name
        session.start()
        if complaint:
            client.add_notification("This address cannot be used", complaint, color="red", auto_close_seconds=15.0)

    async def _wait_until_left(self, name: str) -> None:
        """Wait for the end of a page that is reloaded: a busy server notices it after the new beginning.

        A tab that was duplicated has the same name, and its first one stays; it is not waited for longer.
        """
        deadline = time.monotonic() + _LONGEST_GOODBYE
        while name and time.monotonic() < deadline:
            with self._lock:
                if name not in self._names.values():
                    return
            await asyncio.sleep(0.02)

    def _asked(self, request: Request) -> tuple[State, str, str]:
        """The state and the lesson's step that a page's address asks for, and what is wrong with it, if anything."""
        asked = parse_qs(urlsplit(request.path).query)
        try:
            fragment = read_fragment(asked.get("fragment", [""])[0])
            state = replace(self._state, dark=True) if "dark" in asked else self._state  # as the browser prefers it
            if fragment.step:
                lesson, number = step_named(fragment.step)
                state = replace(lesson.steps[number].state, dark=state.dark)
            if fragment.code:
                state = decode(fragment.code)
            return self._library.checked(state), fragment.step, ""
        except StateError as error:
            return self._state, "", str(error)

    def _shown_address(self, request: Request) -> str:
        """The address of a page without its fragment, as others can open it, or else as its own browser did."""
        origin, its = request.headers.get("Origin"), self.entrance
        if not origin or (its.is_open and origin.lower() not in its.guests.origins):
            return its.address + (its.query or "/")
        path = parse_qs(urlsplit(request.path).query).get("path", ["/"])[0]  # a proxy's may be longer than ours
        return f"{origin}/{quote(path.removeprefix('/'))}{its.query.removeprefix('/')}"

    async def _close(self, client: viser.ClientHandle) -> None:
        """Keep what a page has left; on the server's loop, or one that is reloaded at once would come before that."""
        with self._lock:
            session = self._sessions.pop(client.client_id, None)
            name = self._names.pop(client.client_id, "")
        if session is None:
            return
        if name:
            self._away.keep(name, session)
        await asyncio.to_thread(session.leave if name else session.close)


def _name(request: Request) -> str:
    """What a page calls itself each time that it connects; empty if it does not, or not with a name nobody guesses."""
    name = parse_qs(urlsplit(request.path).query).get("page", [""])[0]
    return name if len(name) >= _SHORTEST_NAME else ""
