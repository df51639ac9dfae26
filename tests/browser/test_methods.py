"""Baselines in the panes, and the comparison of all methods."""

from __future__ import annotations

import numpy as np
import pytest
from explorer import Explorer, box_of


def test_a_scene_of_the_shipped_results_is_opened(explorer: Explorer):
    explorer.open_tab("Sweeps")
    explorer.choose("Sweep", "rotation")
    before = explorer.chart_picture(2)
    explorer.choose("Method", "Improved DO")
    explorer.choose("Level", "180")
    explorer.choose("Score", "PointRMSE")
    explorer.wait_until("another score's curves", lambda: explorer.chart_picture(2) != before)
    explorer.wait_until("its scenes", lambda: "PointAcc" in explorer.field("Scene").input_value())
    scene = explorer.field("Scene").input_value()
    explorer.press("Open this scene")
    explorer.wait_until("the scene", lambda: explorer.state().perturbation.rotation == 180)
    state = explorer.expect_to_agree()
    accuracy = explorer.numbers()["PointAcc"][1]
    assert state.right == "Improved DO"
    assert abs(float(accuracy) - float(scene.split()[-1].rstrip(")"))) <= 0.02


@pytest.mark.looks_at_canvas
def test_a_model_point_is_picked_by_a_click_and_looked_into(explorer: Explorer):
    explorer.inspect()
    explorer.choose("Its question", "up / down")
    canvas = box_of(explorer.canvas())
    before = explorer.canvas_halves()[1]
    for share in (0.52, 0.5, 0.54, 0.56, 0.48):  # whichever is on a point
        explorer.page.mouse.click(canvas["x"] + 0.74 * canvas["width"], canvas["y"] + share * canvas["height"])
        explorer.pause(600)
        if explorer.state().inspected >= 0:
            break
    point = explorer.state().inspected
    assert point >= 0
    assert explorer.state().inspected_pane == "right"
    explorer.page.get_by_text(f"model point {point}", exact=True).wait_for()
    assert explorer.field("Model point").input_value() == str(point)
    changed = np.abs(explorer.canvas_halves()[1] - before).max(axis=2) > 60
    assert changed.sum() > 500
    explorer.choose("Model colours", "whole update")
    explorer.type_into("Model point", "99999999")
    explorer.wait_until("the last point", lambda: explorer.state().inspected == 513)
    explorer.type_into("Model point", "-1")
    explorer.wait_until("no point", lambda: explorer.state().inspected == -1)
    explorer.expect_alive()
