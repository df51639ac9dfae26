"""What a pane draws of what is looked into."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import viser

from ido import Model, Perturbation, TripleBinary, shipped_cloud
from ido_viz.canvas.pane import PaneView
from ido_viz.core.changes import within_run
from ido_viz.core.chart_data import histogram_data
from ido_viz.core.frame import frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute
from ido_viz.core.state import State

PICKED = State(perturbation=Perturbation(points=100), max_iterations=5, inspected=7, playing=False)


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(PICKED, shipped_library())


@pytest.fixture
def panes() -> Iterator[tuple[PaneView, PaneView]]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        yield PaneView(server.scene, 0), PaneView(server.scene, 1)
    finally:
        server.stop()


def diagram(pane: PaneView) -> dict[str, Any]:
    """What is drawn of a diagram, by name."""
    nodes: Any = pane._diagram._scene._handle_from_node_name
    root = f"{pane._diagram._root}/"
    return {name.removeprefix(root): node for name, node in nodes.items() if name.startswith(root)}


def test_the_picked_point_lights_up_in_both_panes_and_its_question_in_one(run: Run, panes: tuple[PaneView, PaneView]):
    point = run.sides[0].histogram.model.points[7]
    for left, right in ((panes[0], panes[1]), (panes[1], panes[0])):
        looked_into = ("left", "right")[right._pane]
        frame = frame_of(run, replace(PICKED, inspected_pane=looked_into))
        for pane in panes:
            pane.draw(frame)
            np.testing.assert_allclose(diagram(pane)["point"].position, point, atol=1e-6)
        assert set(diagram(left)) == {"point", "point/rim"} < set(diagram(right))


def test_the_picked_scene_point_lights_up_where_each_method_has_put_it(run: Run, panes: tuple[PaneView, PaneView]):
    frame = frame_of(run, replace(PICKED, scene_point=3, iteration=2))
    for pane, side in zip(panes, frame.sides, strict=True):
        pane.draw(frame)
        moved = side.T_model_scene @ np.append(run.scene.points[3], 1.0)
        np.testing.assert_allclose(diagram(pane)["partner"].position, moved[:3], atol=1e-6)


@pytest.mark.parametrize("changes", [{"inspected": -1}, {"right": "ICP, tuned"}], ids=["none", "of no maps"])
def test_without_a_picked_point_nothing_lights_up(run: Run, panes: tuple[PaneView, PaneView], changes: dict[str, Any]):
    state = replace(PICKED, **changes)
    frame = frame_of(compute(state, shipped_library()), state)
    for pane in panes:
        pane.draw(frame)
        assert diagram(pane) == {}


def test_a_method_with_another_model_marks_no_point_of_it(run: Run, panes: tuple[PaneView, PaneView]):
    baseline = compute(replace(PICKED, right="ICP, tuned"), shipped_library()).sides[1]
    other = replace(baseline, histogram=TripleBinary(Model.of(shipped_cloud("bunny"), 64)))
    frame = frame_of(replace(run, sides=(run.sides[0], other)), replace(PICKED, inspected=300, inspected_pane="left"))
    for pane in panes:
        pane.draw(frame)
    assert "point" in diagram(panes[0]) and diagram(panes[1]) == {}
    marks = [np.isfinite(histogram_data(side, frame.state)[-1]).sum() for side in frame.sides]
    assert marks[0] == 2 * len(run.sides[0].histogram.blocks) and marks[1] == 0
    assert within_run({"inspected": 9999}, frame.state, frame.run) == {"inspected": 513}
    assert within_run({"inspected": 9999, "inspected_pane": "right"}, frame.state, frame.run)["inspected"] == 63


def test_in_the_slow_motion_the_point_lights_up_where_it_is_asked(run: Run, panes: tuple[PaneView, PaneView]):
    frame = frame_of(run, replace(PICKED, inside=1.5, iteration=1))
    for pane in panes:
        pane.draw(frame)
    assert diagram(panes[0]) == {}
    assert "point" in diagram(panes[1])
