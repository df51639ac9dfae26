"""What the tests share: the shipped bunny, a small model of it, and a small training on that; and tabs."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from tab import PAUSED, Computing, Nothing, Tab, WidgetsOfTab

from ido import Cloud, FrontBack, Maps, Model, TrainingSettings, shipped_cloud, train
from ido_viz import live as live_module
from ido_viz import session as session_module
from ido_viz.state import State

SMALL_MODEL = 80
SMALL_TRAINING = TrainingSettings(samples=600, maps=8)


@pytest.fixture(scope="session")
def bunny() -> Cloud:
    return shipped_cloud("bunny")


@pytest.fixture(scope="session")
def small_model(bunny: Cloud) -> Model:
    return Model.of(bunny, SMALL_MODEL)


@pytest.fixture(scope="session")
def full_model(bunny: Cloud) -> Model:
    return Model.of(bunny)


@pytest.fixture(scope="session")
def small_maps(bunny: Cloud, small_model: Model) -> Maps:
    return train(bunny, FrontBack(small_model), SMALL_TRAINING)


@pytest.fixture
def computing(monkeypatch: pytest.MonkeyPatch) -> Computing:
    computing = Computing()
    monkeypatch.setattr(session_module, "Controls", WidgetsOfTab)
    monkeypatch.setattr(session_module, "Panels", Nothing)
    monkeypatch.setattr(session_module, "Canvas", Nothing)
    monkeypatch.setattr(live_module, "make_scene", computing)
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
