"""What the tests of sessions share: tabs without a browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from seen import Seen
from tab import PAUSED, Computing, PageOfTab, Tab

from ido_viz import requests, session
from ido_viz.core import live_run
from ido_viz.core.state import State


@pytest.fixture
def seen() -> Seen:
    return Seen()


@pytest.fixture
def computing(monkeypatch: pytest.MonkeyPatch) -> Computing:
    computing = Computing()
    monkeypatch.setattr(session, "Page", PageOfTab)
    monkeypatch.setattr(requests, "FIRST_LOOK", 0.05)
    monkeypatch.setattr(live_run, "make_scene", computing)
    return computing


@pytest.fixture
def open_tab(computing: Computing) -> Iterator[Callable[..., Tab]]:
    tabs: list[Tab] = []

    def open_one(state: State = PAUSED, *, calm: bool = True) -> Tab:
        tabs.append(Tab(state))
        if calm:
            tabs[-1].settle()
        return tabs[-1]

    yield open_one
    computing.go.set()
    for tab in tabs:
        tab.session.close()
        tab.wait("the end of the session", lambda tab=tab: not tab.is_served)


@pytest.fixture
def tab(open_tab: Callable[..., Tab]) -> Tab:
    return open_tab()
