"""One browser for all tests, one page for each, and a page's own errors fail its test."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from explorer import AT_THE_END, SMALL, Explorer, OpenExplorer
from playwright.sync_api import Browser, ViewportSize, sync_playwright

from ido_viz import requests
from ido_viz.app import App
from ido_viz.core.state import State

FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-accelerated-2d-canvas",
    "--disable-gpu-compositing",  # without a graphics card, drawing what changed alone is several times faster
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


WITHOUT_DRAWING = """for (const of of [WebGLRenderingContext, WebGL2RenderingContext])
    for (const name of ["clear", "drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced"])
        if (of.prototype[name]) of.prototype[name] = () => {};"""
"""A page's 3D scene without its pixels: drawn in software, they take most of the time of a browser test."""


def chromium() -> str | None:
    """Where Chromium is, if it is anywhere."""
    candidates = (os.environ.get("CHROMIUM"), "/usr/bin/chromium", shutil.which("chromium"))
    return next((path for path in candidates if path and Path(path).exists()), None)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    executable = chromium()
    if executable is None:
        pytest.skip("no Chromium: install it, or give its path in the environment variable CHROMIUM")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def app_for() -> Iterator[Callable[[State], App]]:
    """The running app whose tabs begin with a state."""
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
def open_explorer(
    request: pytest.FixtureRequest, browser: Browser, app_for: Callable[[State], App]
) -> Iterator[OpenExplorer]:
    """Opens pages that begin with a state, by default at the end of a registration and not playing.

    Their 3D scene is drawn for tests with the mark `looks_at_canvas` alone.
    """
    opened: list[Explorer] = []
    draws = request.node.get_closest_marker("looks_at_canvas") is not None

    def open_page(state: State = AT_THE_END, size: tuple[int, int] = SMALL, *, wait: bool = True) -> Explorer:
        viewport = ViewportSize(width=size[0], height=size[1])
        explorer = Explorer(app_for(state), browser.new_page(viewport=viewport))
        if not draws:
            explorer.page.add_init_script(WITHOUT_DRAWING)
        opened.append(explorer)
        if wait:
            explorer.open()
        return explorer

    yield open_page
    errors = [error for explorer in opened for error in explorer.errors]
    for explorer in opened:
        explorer.page.close()
    assert errors == []


@pytest.fixture
def explorer(open_explorer: OpenExplorer) -> Explorer:
    """A page at the end of a registration, not playing."""
    return open_explorer()
