"""The control of a step: what a file may name, and what the widget does."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest
import viser
from headless import run

from ido import RANGES
from ido_viz.core.actions import Actions
from ido_viz.core.state import State
from ido_viz.teach.content import ContentError
from ido_viz.teach.step_control import ControlView, StepControl, control_of

FAR = replace(State(), perturbation=replace(State().perturbation, rotation=90.0))


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


class Desk:
    """A control, a person who uses it, and what it asked of the page."""

    def __init__(self, server: viser.ViserServer, control: StepControl) -> None:
        self.asked: list[Any] = []
        note = self.asked.append
        actions = SimpleNamespace(
            play=lambda: note("play"),
            step=lambda by: note(("step", by)),
            jump=lambda to: note(("jump", to)),
            new_seed=lambda: note("new seed"),
            map_basin=lambda: note("map the basin"),
            set_values=note,
        )
        self.folder = server.gui.add_folder(None)
        with self.folder:
            self.view = ControlView(server.gui, control, State(), cast(Actions, actions))
        (self.widget,) = cast(Any, self.folder)._children.values()

    def use(self, value: Any = None) -> None:
        """Use it as a browser does: what is no coroutine has its turn when a frame of before has been drawn."""
        self.widget._impl.value = value
        event = SimpleNamespace(target=self.widget, client=object())
        callbacks = self.widget._impl.update_cb
        for callback in filter(inspect.iscoroutinefunction, callbacks):
            run(callback(event))
        self.view.follow(State())
        for callback in callbacks:
            if not inspect.iscoroutinefunction(callback):
                callback(event)


@pytest.mark.parametrize(
    ("name", "asked"),
    [
        ("Play", "play"),
        ("One iteration on", ("step", 1)),
        ("Back to the start", ("jump", 0)),
        ("New seed", "new seed"),
        ("Map the basin", "map the basin"),
    ],
)
def test_a_button_does_what_it_says(server: viser.ViserServer, name: str, asked: object):
    desk = Desk(server, control_of(name, ""))
    desk.use()
    assert desk.asked == [asked]


@pytest.mark.parametrize("name", RANGES)
def test_a_slider_sets_its_value_and_follows_the_page(server: viser.ViserServer, name: str):
    desk = Desk(server, control_of(name, ""))
    assert desk.widget.value == getattr(State().perturbation, name)
    assert (desk.widget.min, desk.widget.max) == (RANGES[name].low, RANGES[name].high)
    desk.use(RANGES[name].high)
    assert desk.asked == [{name: RANGES[name].high}]
    desk.view.follow(FAR)
    assert desk.widget.value == getattr(FAR.perturbation, name)


def test_choices_are_buttons_for_values(server: viser.ViserServer):
    desk = Desk(server, control_of({"seed": [6, 3]}, ""))
    assert (desk.widget.label, desk.widget.options) == ("Seed", ("6", "3"))
    desk.use("3")
    desk.view.follow(FAR)
    on_off = Desk(server, control_of({"difference": [False, True]}, ""))
    on_off.use("on")
    small = Desk(server, control_of({"epsilon": [0.0001, 0.01]}, ""))
    small.use("0.0001")
    order = Desk(server, control_of({"order": ["reference value", "azimuth"]}, ""))
    order.use("azimuth")
    asked = [*desk.asked, *on_off.asked, *small.asked, *order.asked]
    assert asked == [{"seed": 3}, {"difference": True}, {"epsilon": 0.0001}, {"order": "azimuth"}]


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("rotatoin", "step 1: unknown control 'rotatoin'; known: noise, .*rotation.*, Play, .*or a value with"),
        (1, r"step 1: a control is a name, or one value with its choices, as \{seed = \[4, 0\]\}, not 1"),
        ({"seed": [1, 2], "points": [100, 200]}, "step 1: a control is a name, or one value"),
        ({"sede": [1, 2]}, "step 1: a control is a name, or one value"),
        ({"seed": [1]}, "step 1: the control 'seed' needs an array of two or more choices"),
        ({"seed": 1}, "step 1: the control 'seed' needs an array"),
        ({"rotation": [0, 900]}, "step 1: control: rotation must lie between 0 and 180"),
    ],
)
def test_a_mistake_in_a_control_is_told(written: object, message: str):
    with pytest.raises(ContentError, match=f"^{message}"):
        control_of(written, "step 1")
