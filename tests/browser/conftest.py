"""One browser for all tests, one page for each, and a page's own errors fail its test."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from any_explorer import AT_THE_END, AT_THE_START
from apps import app_for as app_for
from apps import no_waiting as no_waiting
from browser_pages import BrowserPages, new_page
from explorer import SMALL, Explorer, OpenExplorer
from playwright.sync_api import Browser, ViewportSize, sync_playwright

from ido_viz.app import App
from ido_viz.core.state import State

FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-accelerated-2d-canvas",
    "--disable-gpu-compositing",  # without a graphics card, drawing what changed alone is several times faster
    "--js-flags=--single-threaded",  # threads that help to compile and to collect take the processors from other tests
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def chromium() -> str | None:
    """Where Chromium is, if it is anywhere: rather the shell that only shows pages, as Playwright's own is."""
    its_shell = shutil.which("chromium-headless-shell")  # takes a sixteenth less time
    candidates = (os.environ.get("CHROMIUM"), its_shell, "/usr/bin/chromium", shutil.which("chromium"))
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


@pytest.fixture
def draws(request: pytest.FixtureRequest) -> bool:
    """Whether the test sees the 3D scene: that takes time."""
    return request.node.get_closest_marker("looks_at_canvas") is not None


@pytest.fixture(scope="session")
def browser_pages(browser: Browser) -> BrowserPages:
    """The pages that tests leave to each other."""
    return BrowserPages(browser)


@pytest.fixture
def open_explorer(browser_pages: BrowserPages, app_for: Callable[[State], App], draws: bool) -> Iterator[OpenExplorer]:
    """Opens pages that begin with a state, by default at the end of a registration and not playing."""
    opened: list[Explorer] = []

    def open_page(state: State = AT_THE_END, size: tuple[int, int] = SMALL, *, wait: bool = True) -> Explorer:
        opened.append(Explorer(app_for(state), browser_pages.take(size, draws=draws)))
        return opened[-1].open() if wait else opened[-1]

    yield open_page
    for explorer in opened:
        browser_pages.give_back(explorer.leave(), draws=draws)
    assert [error for explorer in opened for error in explorer.errors] == []


@pytest.fixture
def fresh_explorer(browser: Browser, app_for: Callable[[State], App]) -> Iterator[Explorer]:
    """A page of its own, not yet open, for a test that changes the browser."""
    page = new_page(browser, viewport=ViewportSize(width=SMALL[0], height=SMALL[1]))
    explorer = Explorer(app_for(AT_THE_END), page)
    yield explorer
    page.close()
    assert explorer.errors == []


@pytest.fixture(scope="session")
def kept_pages() -> Iterator[dict[bool, Explorer]]:
    """The pages that tests use one after another, each of an app of its own, by whether they draw."""
    pages: dict[bool, Explorer] = {}
    yield pages
    for explorer in pages.values():
        explorer.app.stop()


@pytest.fixture
def explorer(browser_pages: BrowserPages, kept_pages: dict[bool, Explorer], draws: bool) -> Iterator[Explorer]:
    """A page at the end of a registration, not playing: that of the test before, put back, which is quicker."""
    kept = kept_pages.pop(draws, None)  # one that cannot be put back is not kept
    if kept is None:
        kept = Explorer(App(AT_THE_END, port=0), browser_pages.take(SMALL, draws=draws)).open()
    else:
        kept.rest(False)
    yield kept
    assert kept.errors == []
    kept.put_back(AT_THE_END)
    kept.rest(True)
    kept_pages[draws] = kept


@pytest.fixture
def at_the_start(explorer: Explorer) -> Explorer:
    """A page before the first iteration, not playing."""
    explorer.press("First (R)")
    explorer.expect_numbers(AT_THE_START)
    return explorer
