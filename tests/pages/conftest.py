"""Pages that nobody sees, each of a test of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from any_explorer import AT_THE_END, AT_THE_START
from unseen_explorer import OpenUnseen, UnseenExplorer

from ido_viz import requests
from ido_viz.app import App
from ido_viz.core.state import State


@pytest.fixture(scope="session")
def app_for() -> Iterator[Callable[[State], App]]:
    """The running app whose pages begin with a state."""
    apps: dict[State, App] = {}

    def started(state: State) -> App:
        if state not in apps:
            apps[state] = App(state, port=0)
        return apps[state]

    yield started
    for app in apps.values():
        app.stop()


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Prepared pages play at once."""
    monkeypatch.setattr(requests, "FIRST_LOOK", 0.1)


@pytest.fixture
def open_unseen(app_for: Callable[[State], App]) -> Iterator[OpenUnseen]:
    """Opens pages that begin with a state, by default at the end of a registration and not playing."""
    opened: list[UnseenExplorer] = []

    def open_page(state: State = AT_THE_END, app: App | None = None, query: str = "") -> UnseenExplorer:
        opened.append(UnseenExplorer(app or app_for(state), query))
        return opened[-1]

    yield open_page
    for explorer in opened:
        if explorer.is_open:
            explorer.close()


@pytest.fixture
def explorer(open_unseen: OpenUnseen) -> UnseenExplorer:
    """A page at the end of a registration, not playing."""
    return open_unseen()


@pytest.fixture
def at_the_start(open_unseen: OpenUnseen) -> UnseenExplorer:
    """A page before the first iteration, not playing."""
    return open_unseen(AT_THE_START)
