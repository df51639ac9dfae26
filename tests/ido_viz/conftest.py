"""What tests share: tabs without a browser, and a cloud that is quickly learned, badly."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from seen import Seen
from tab import PAUSED, Computing, PageOfTab, Tab

from ido import Cloud, Model, TrainingSettings, train
from ido.clouds import Frame
from ido_viz import requests, session
from ido_viz.core import live_run
from ido_viz.core.state import State
from ido_viz.own.draft import Draft
from ido_viz.own.kept import TRAINED, KeptCloud

TINY = TrainingSettings(samples=60, maps=2, rotation=120.0, translation=0.5)


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


@pytest.fixture(scope="session")
def tiny_draft(bunny: Cloud) -> Draft:
    """A thousand points of the bunny, in millimetres, and 64 model points."""
    some = np.random.default_rng(0).choice(len(bunny.points), 1000, replace=False)
    cloud = Cloud(bunny.points[some], Frame(np.array([10.0, -20.0, 30.0]), 78.0))
    return Draft("tiny", cloud, Model.of(cloud, 64), read=1000, unit="mm", up="+y")


@pytest.fixture(scope="session")
def kept(tiny_draft: Draft) -> KeptCloud:
    maps = {name: train(tiny_draft.cloud, kind(tiny_draft.model), TINY) for name, kind in TRAINED.items()}
    return KeptCloud("tiny", "mm", "+y", tiny_draft.cloud, maps)


@pytest.fixture
def default_interrupts() -> Iterator[None]:
    """What is started in the background ignores Ctrl-C, and hands that on."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
