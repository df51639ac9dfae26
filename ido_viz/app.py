"""The server: one session for each browser tab."""

from __future__ import annotations

import threading

import viser

from ido.console import hush
from ido_viz.core.library import Library, shipped_library
from ido_viz.core.state import State
from ido_viz.session import Session
from ido_viz.teach.derivations import derivations
from ido_viz.teach.lessons import lessons
from ido_viz.teach.presets import presets


class App:
    """A running explorer.

    Args:
        state: what a new tab shows.
        library: the shapes and methods on offer; the shipped ones unless given.
        host: address to listen on.
        port: port to listen on; a busy one moves on to the next free one.

    Raises:
        StateError: the state's shape or methods are not in the library.
        ContentError: a lesson, preset or derivation has a mistake.
    """

    def __init__(
        self,
        state: State | None = None,
        *,
        library: Library | None = None,
        host: str = "127.0.0.1",
        port: int = 8080,
    ) -> None:
        self._library = library or shipped_library()
        self._state = self._library.checked(state or State())
        for load in (lessons, presets, derivations):
            load()  # a mistake in one is said here, not when a tab is opened
        self._sessions: dict[int, Session] = {}
        self._lock = threading.Lock()
        with hush():  # the command prints the address itself
            self.server = viser.ViserServer(host=host, port=port, label="IDO Explorer", verbose=False)
        self.server.scene.world_axes.visible = False
        self.server.on_client_connect(self._open)
        self.server.on_client_disconnect(self._close)

    @property
    def url(self) -> str:
        """Where the page really is."""
        host = self.server.get_host()
        shown = "127.0.0.1" if host in ("0.0.0.0", "::", "") else host
        return f"http://{shown}:{self.server.get_port()}"

    @property
    def n_sessions(self) -> int:
        """How many tabs are open."""
        return len(self._sessions)

    def stop(self) -> None:
        """Close all tabs' sessions and stop listening."""
        with self._lock:
            sessions = list(self._sessions.values())
            self._sessions.clear()
        for session in sessions:
            session.close()
        with hush():
            self.server.stop()

    def _open(self, client: viser.ClientHandle) -> None:
        session = Session(client, self._library, self._state)
        with self._lock:
            if client.client_id not in self.server.get_clients():  # gone again already
                return
            self._sessions[client.client_id] = session
        session.start()

    def _close(self, client: viser.ClientHandle) -> None:
        with self._lock:
            session = self._sessions.pop(client.client_id, None)
        if session is not None:
            session.close()
