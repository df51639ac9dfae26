"""The widgets of a page, made on a real server without a browser: what they show is what they are read as."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import viser

import ido_viz
from ido import RANGES, Perturbation
from ido.perturbation import LARGEST_SEED
from ido_viz.core.actions import Actions
from ido_viz.core.frame import frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.core.state import LAST, LONGEST_RUN, MOST_MAPS, NO_START, State
from ido_viz.panels.controls import Controls
from ido_viz.teach import step_control

LIBRARY = shipped_library()
LOWEST = Perturbation(noise=0.0, points=100, outliers=0, incomplete=0.0, rotation=0.0, translation=0.0, seed=0)
HIGHEST = Perturbation(
    noise=0.1,
    points=4000,
    outliers=600,
    incomplete=0.7,
    rotation=180.0,
    translation=1.0,
    outlier_kind="structured",
    seed=LARGEST_SEED,
)
STATES = [
    State(),
    State(perturbation=LOWEST, max_iterations=1, speed=1, epsilon=1e-5, pinned_map=1),
    State(perturbation=HIGHEST, max_iterations=LONGEST_RUN, speed=60, epsilon=0.1, pinned_map=30),
    State(left="Improved DO (as printed)", right="DO", order="azimuth", difference=True, ghost=False, dark=True),
    LIBRARY.at_shape(State(left="Improved DO", right="DO", order="elevation"), "urban"),
    State(iteration=LAST, playing=False),
    State(error_vectors=True, overlay="another iteration", overlaid_iteration=7, large_text=True),
    State(overlay="other method", hidden=("scores", "methods", "lower charts")),
    State(pinned_map=40),  # more than the shipped methods have: another's code
    State(pinned_map=MOST_MAPS),
    State(replay=False, handles=False),
]
CARRIED = State(start=(0.1, 0.2, -0.3, 0.4, 0.5, -0.6), camera=(0.1, -0.9, 0.4, 0.0, 0.0, 0.2), playing=False)


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


@pytest.fixture
def controls(server: viser.ViserServer) -> Iterator[Controls]:
    server.gui.reset()
    yield controls_for(server, State())
    server.gui.reset()


def controls_for(server: viser.ViserServer, state: State) -> Controls:
    def nothing(*_: object) -> Any:
        pass

    actions = Actions(*[nothing] * len(fields(Actions)))
    return Controls(cast(viser.ClientHandle, SimpleNamespace(gui=server.gui)), LIBRARY, state, actions)


@pytest.mark.parametrize("state", STATES, ids=range(len(STATES)))
def test_widgets_made_for_a_state_are_read_as_it(server: viser.ViserServer, state: State):
    server.gui.reset()
    assert controls_for(server, state).read(state) == (state, True)


@pytest.mark.parametrize("state", STATES, ids=range(len(STATES)))
def test_a_shown_state_is_read_as_it(controls: Controls, state: State):
    controls.show(state)
    moved_on = replace(State(), iteration=state.iteration, playing=state.playing)
    assert controls.read(moved_on) == (state, True)


def test_states_shown_one_after_another_leave_nothing_behind(controls: Controls):
    for state in [*STATES, *STATES[::-1]]:
        controls.show(state)
        assert controls.read(state) == (state, True)


def test_reading_keeps_what_no_widget_shows(controls: Controls):
    controls.show(State())
    for state in (State(iteration=5), State(iteration=LAST, playing=False)):
        assert controls.read(state)[0] == state


def test_the_sliders_show_how_far_a_carried_scene_is_from_its_place(controls: Controls):
    controls.show(CARRIED)
    away = np.linalg.inv(compute(CARRIED, LIBRARY).scene.T_model_scene)
    turned = np.rad2deg(np.arccos((np.trace(away[:3, :3]) - 1) / 2))
    assert controls._inputs["rotation"].value == pytest.approx(turned, abs=0.5)
    assert controls._inputs["translation"].value == pytest.approx(np.linalg.norm(away[:3, 3]), abs=0.005)
    assert controls.read(CARRIED) == (CARRIED, True)


def test_whatever_else_is_changed_a_carried_scene_stays_so(controls: Controls):
    controls.show(CARRIED)
    controls._inputs["noise"].value, controls._inputs["dark"].value = 0.01, True
    expected = replace(CARRIED, dark=True, perturbation=replace(CARRIED.perturbation, noise=0.01))
    assert controls.read(CARRIED) == (expected, True)


@pytest.mark.parametrize(
    ("name", "value", "other"), [("rotation", 12.0, "translation"), ("translation", 0.9, "rotation")]
)
def test_moving_one_of_its_sliders_lets_go_of_it(controls: Controls, name: str, value: float, other: str):
    controls.show(CARRIED)
    left = controls._inputs[other].value
    controls._inputs[name].value = value
    state, usable = controls.read(CARRIED)
    assert usable
    assert state == replace(
        CARRIED, start=NO_START, perturbation=replace(CARRIED.perturbation, **{name: value, other: left})
    )


def test_a_scene_carried_far_away_leaves_the_sliders_at_their_ends(controls: Controls):
    far = replace(CARRIED, start=(15.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    controls.show(far)
    assert controls._inputs["translation"].value == RANGES["translation"].high
    assert controls.read(far) == (far, True)


def test_values_beyond_the_widgets_are_brought_into_their_range(controls: Controls):
    for name, allowed in RANGES.items():  # as a client may send them, whatever its widgets allow
        controls._inputs[name].value = int(allowed.limit) if name in ("points", "outliers") else allowed.limit
    controls._inputs["epsilon"].value = 1.0
    controls._inputs["seed"].value = LARGEST_SEED
    state, usable = controls.read(State())
    assert not usable
    assert state.perturbation == replace(HIGHEST, outlier_kind="uniform")
    assert state.epsilon == 0.1


def test_a_method_that_another_shape_lacks_gives_way_to_a_learned_one(controls: Controls) -> None:
    state = State(left="ICP, tuned", right="Improved DO (as printed)")
    controls.show(state)
    inputs = controls._inputs
    inputs["shape"].value = "urban"
    read, _ = controls.read(state)
    at_urban = LIBRARY.at_shape(read, "urban")
    assert (at_urban.left, at_urban.right) == ("ICP, tuned", "Improved DO")


def test_every_map_of_the_shown_methods_can_be_pinned_and_no_other(controls: Controls) -> None:
    state = State(perturbation=Perturbation(points=100), max_iterations=3)
    run = compute(state, LIBRARY)
    assert run.sides[0].maps is not None
    maps = replace(run.sides[0].maps, maps=np.repeat(run.sides[0].maps.maps, 2, axis=0)[:50])
    with_50 = replace(run, sides=(replace(run.sides[0], maps=maps), run.sides[1]))
    slider = controls._inputs["pinned_map"]
    for shown, most in ((with_50, 50), (run, 30)):
        controls.draw(frame_of(shown, state), may_cancel=False)
        assert slider.max == most
    controls.draw(frame_of(with_50, state), may_cancel=False)
    controls._inputs["follow"].value, slider.value = False, 47
    pinned, usable = controls.read(state)
    assert usable and pinned.pinned_map == 47
    assert [side.shown_map for side in frame_of(with_50, pinned).sides] == [47, 30]


def test_every_control_has_a_hint():
    """Of everything that a person can click or type into, but a lesson's control: a hint covers what names it."""
    kinds = ("button", "button_group", "checkbox", "dropdown", "multi_slider", "number", "rgb", "slider", "text")
    adding = {f"add_{kind}" for kind in kinds}
    otherwise, found = [], 0
    for path in Path(ido_viz.__path__[0]).rglob("*.py"):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute) and call.func.attr in adding:
                found += 1
                has_one = any(keyword.arg == "hint" for keyword in call.keywords)
                if has_one == (path == Path(step_control.__file__)):
                    otherwise.append(f"{path.name}:{call.lineno}")
    assert found > 25
    assert otherwise == []
