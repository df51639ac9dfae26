"""Many tabs at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from explorer import AT_THE_END, Explorer, OpenExplorer, page_without_3d
from playwright.sync_api import Browser

from ido_viz.app import App
from ido_viz.core.state import State

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")


def test_two_tabs_do_not_disturb_each_other(open_explorer: OpenExplorer):
    one, other = open_explorer(), open_explorer()
    untouched = other.state()
    one.drag("Noise", 0.9)
    one.choose("Left pane", "Improved DO (as printed)")
    one.press("First (R)")
    one.wait_until("the first iteration", lambda: one.iteration() == 0)
    one.expect_to_agree()
    assert other.expect_to_agree() == untouched
    value = other.drag("Rotation", 0.1)
    other.wait_until("the other rotation", lambda: other.state().perturbation.rotation == value)
    changed = other.expect_to_agree()
    assert changed.perturbation.noise == untouched.perturbation.noise
    assert one.expect_to_agree().perturbation.rotation == untouched.perturbation.rotation


def test_ten_tabs_at_once_get_ready_and_are_freed_when_closed(open_explorer: OpenExplorer):
    state = replace(AT_THE_END, speed=30)  # an app of their own
    tabs = [open_explorer(state, (500, 400), wait=False) for _ in range(10)]
    for tab in tabs:
        tab.page.goto(tab.app.url, wait_until="commit")
    for tab in tabs:
        tab.wait_ready()
        tab.expect_numbers(state)
    (app,) = {tab.app for tab in tabs}
    assert app.n_sessions == 10
    for tab in tabs[1:]:
        tab.page.close()
    tabs[0].wait_until("nine freed sessions", lambda: app.n_sessions == 1)
    tabs[0].expect_alive()
    tabs[0].page.goto("about:blank")
    tabs[0].wait_until("the last freed session", lambda: app.n_sessions == 0)


def test_tabs_closed_before_they_are_ready_are_freed(
    browser: Browser, app_for: Callable[[State], App], open_explorer: OpenExplorer
):
    state = replace(AT_THE_END, speed=29)  # an app of their own
    app = app_for(state)
    for patience in (0, 100, 400):
        page = page_without_3d(browser)
        page.goto(app.url)
        page.wait_for_timeout(patience)
        page.close()
    explorer = open_explorer(state)
    explorer.wait_until("no session but this one", lambda: app.n_sessions == 1)
    explorer.expect_alive()


def test_reloading_a_page_keeps_what_it_shows_and_frees_the_session_before(explorer: Explorer):
    begun = explorer.state()
    explorer.drag("Noise", 0.1)
    explorer.wait_until("less noise", lambda: explorer.state() != begun)
    changed = explorer.expect_to_agree()
    explorer.wait_until("its address", lambda: explorer.page.url.endswith(explorer.code()))
    explorer.page.reload()
    explorer.wait_ready()
    assert explorer.expect_to_agree() == changed
    explorer.wait_until("the session before to be freed", lambda: explorer.app.n_sessions == 1)
