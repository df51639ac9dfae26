"""A method of the user's own in a real page, and a broken one beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from any_explorer import AT_THE_START
from browser_pages import BrowserPages
from explorer import SMALL, Explorer

from ido import Cloud
from ido.extensions import find_class
from ido.types import FloatArray
from ido_viz.app import App
from ido_viz.core.library import Library, shipped_library
from ido_viz.core.state import State

EXAMPLE = Path(__file__).parents[2] / "assets" / "examples" / "04_own_method.py"
PERSONAL = "Point to plane"


class Broken:
    """Makes two steps, then fails with a message that would be a picture if it were HTML."""

    def __init__(self, cloud: Cloud) -> None:
        pass

    def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
        if x[0] > 0.15:
            raise RuntimeError("<img src=x> is no step")
        return np.full(6, 0.1)


@pytest.fixture(scope="module")
def library() -> Library:
    """With the example's own method, and a broken one."""
    return shipped_library().with_methods({PERSONAL: find_class(f"{EXAMPLE}:PointToPlane"), "Broken": Broken})


@pytest.fixture
def open_own(library: Library, browser_pages: BrowserPages) -> Iterator[Callable[[State], Explorer]]:
    opened: list[Explorer] = []

    def open_page(state: State) -> Explorer:
        page = browser_pages.take(SMALL, draws=False)
        opened.append(Explorer(App(state, library=library, port=0), page))
        return opened[-1].open()

    yield open_page
    for explorer in opened:
        browser_pages.give_back(explorer.leave(), draws=False)
        explorer.app.stop()
    assert [error for explorer in opened for error in explorer.errors] == []


def test_a_broken_method_shows_its_traceback_and_the_other_pane_works(open_own: Callable[[State], Explorer]):
    explorer = open_own(replace(AT_THE_START, left="Broken"))
    trace = explorer.page.locator(".trace")
    trace.wait_for()
    text = trace.inner_text()
    assert text.startswith("Traceback (most recent call last)")
    assert "test_plugins.py" in text and "RuntimeError: <img src=x> is no step" in text
    assert trace.locator("img").count() == 0
    assert explorer.numbers()["Stops"][0] == "failed: RuntimeError: <img src=x> is no step"
    assert trace.evaluate("box => box.scrollWidth <= box.clientWidth && box.clientHeight < 300")
    explorer.expect_alive()
    rotation = explorer.drag("Rotation", 0.1)
    explorer.wait_until("the other scene", lambda: explorer.numbers()["Rotation error"][0] == f"{rotation:.2f}°")
    assert trace.count() == 1
    assert int(explorer.numbers()["Iteration"][1].split("/")[1]) > 10
    assert explorer.notifications() == []
    explorer.choose("Left pane", PERSONAL)
    explorer.wait_until("no traceback", lambda: trace.count() == 0 and PERSONAL in explorer.methods())
    explorer.wait_until("a histogram", lambda: explorer.chart_ink(0) > 0)
