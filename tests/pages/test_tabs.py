"""Many tabs at once."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from any_explorer import AT_THE_END
from headless import HeadlessTab, run
from unseen_explorer import OpenUnseen

from ido_viz.app import App
from ido_viz.core.state import State

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")


def test_two_tabs_do_not_disturb_each_other(open_unseen: OpenUnseen):
    one, other = open_unseen(), open_unseen()
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


def test_ten_tabs_at_once_get_ready_and_are_freed_when_closed(open_unseen: OpenUnseen, app_for: Callable[[State], App]):
    state = replace(AT_THE_END, speed=30)  # an app of their own
    app = app_for(state)
    with ThreadPoolExecutor(10) as threads:
        tabs = list(threads.map(lambda _: open_unseen(state), range(10)))
    for tab in tabs:
        tab.expect_numbers(state)
    assert app.n_sessions == 10
    for tab in tabs[1:]:
        tab.close()
    tabs[0].wait_until("nine freed sessions", lambda: app.n_sessions == 1)
    tabs[0].expect_alive()
    tabs[0].close()
    tabs[0].wait_until("the last freed session", lambda: app.n_sessions == 0)


def test_tabs_closed_before_they_are_ready_are_freed(app_for: Callable[[State], App], open_unseen: OpenUnseen):
    state = replace(AT_THE_END, speed=29)  # an app of their own
    app = app_for(state)

    async def leave_after(seconds: float) -> None:
        tab = HeadlessTab(app.url)
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(tab.open(), seconds)
        await tab.close()

    for seconds in (0.03, 0.1, 0.4):
        run(leave_after(seconds))
    explorer = open_unseen(state)
    explorer.wait_until("no session but this one", lambda: app.n_sessions == 1)
    explorer.expect_alive()
