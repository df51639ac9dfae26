"""Fixtures of tests that open pages: the apps that serve them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from ido_viz import requests
from ido_viz.app import App
from ido_viz.core.state import State
from ido_viz.serving import values


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
    """Prepared pages play at once, and numbers are soon at rest."""
    monkeypatch.setattr(requests, "FIRST_LOOK", 0.1)
    monkeypatch.setattr(values, "AT_REST", 0.5)
