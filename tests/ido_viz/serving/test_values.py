"""What browsers may write into widgets."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import viser

from ido_viz.serving.values import LONGEST_TEXT, refusal


@pytest.fixture(scope="module")
def gui() -> Iterator[viser.GuiApi]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server.gui
    server.stop()


NONSENSE: tuple[Any, ...] = (None, [], {}, [1], "nothing", float("nan"), float("inf"), 1e308, 10**30)


def made(gui: viser.GuiApi) -> dict[str, Any]:
    """A widget of each kind that our pages have."""
    return {
        "dropdown": gui.add_dropdown("a", ("DO", "ICP")),
        "group": gui.add_button_group("b", ("Next", "Last")),
        "slider": gui.add_slider("c", 0.0, 1.0, 0.1, 0.5),
        "whole": gui.add_slider("d", 0, 10, 1, 5),
        "number": gui.add_number("e", 3, min=0, max=9),
        "tick": gui.add_checkbox("f", False),
        "text": gui.add_text("g", ""),
        "button": gui.add_button("h"),
    }


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("dropdown", "ICP"),
        ("group", "Last"),
        ("slider", 1),
        ("slider", 0.3),
        ("whole", 10),
        ("number", 9),
        ("tick", True),
        ("text", "x" * LONGEST_TEXT),
        ("button", True),
    ],
)
def test_what_a_widget_offers_is_taken(gui: viser.GuiApi, kind: str, value: object):
    assert refusal(made(gui)[kind], value) is None


@pytest.mark.parametrize("kind", ["dropdown", "group", "slider", "whole", "number", "tick", "button"])
@pytest.mark.parametrize("value", NONSENSE, ids=map(repr, NONSENSE))
def test_what_it_does_not_offer_is_refused_in_a_sentence(gui: viser.GuiApi, kind: str, value: object):
    reason = refusal(made(gui)[kind], value)
    assert reason is not None and reason.endswith(".")


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("slider", 1.01),
        ("whole", -1),
        ("number", 1000),
        ("number", -1),
        ("number", True),
        ("tick", 1),
        ("text", 3),
        ("text", "x" * (LONGEST_TEXT + 1)),
    ],
)
def test_what_is_out_of_range_or_of_another_kind_is_refused(gui: viser.GuiApi, kind: str, value: object):
    assert refusal(made(gui)[kind], value) is not None


def test_what_is_disabled_is_disabled_for_every_browser(gui: viser.GuiApi):
    widget = gui.add_button("h", disabled=True)
    assert refusal(widget, True) is not None


def test_a_long_value_is_told_in_short(gui: viser.GuiApi):
    assert len(refusal(made(gui)["dropdown"], "x" * 1000) or "") < 100
