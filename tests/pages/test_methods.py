"""Baselines in the panes, the comparison of all methods, one of one's own, and what a researcher looks for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from any_explorer import AT_THE_START, independent_run
from unseen_explorer import OpenUnseen, UnseenExplorer

from ido import poses
from ido.attribution import bin_name
from ido.extensions import find_class
from ido_viz.app import App
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.panels.compare_tab import COLUMNS

EXAMPLE = Path(__file__).parents[2] / "assets" / "examples" / "04_own_method.py"
PERSONAL = "Point to plane"


def test_a_baseline_registers_steps_and_follows_a_slider(explorer: UnseenExplorer):
    explorer.choose("Left pane", "BCPD, tuned")
    explorer.wait_until("BCPD shown", lambda: "BCPD, tuned" in explorer.methods())
    explorer.expect_to_agree()
    explorer.press("First (R)")
    explorer.wait_until("the start", lambda: explorer.iteration() == 0)
    explorer.press("Next (N)")
    explorer.wait_until("the next iteration", lambda: explorer.iteration() == 1)
    explorer.expect_to_agree()
    explorer.drag("Rotation", 0.7)
    explorer.expect_to_agree()
    explorer.wait_until("what it does without", lambda: explorer.says("learns no maps"))
    assert explorer.charts() == 2


def test_all_methods_are_compared_sorted_and_shown_by_a_click(explorer: UnseenExplorer):
    explorer.open_tab("Compare")
    explorer.press("Compare all methods")
    names = shipped_library().methods("bunny")
    explorer.wait_until("all methods", lambda: explorer.says(f"{len(names)} of {len(names)} methods"))
    explorer.wait_until("all rows", lambda: sum("KCCE (reconstr.)" in row for row in explorer.buttons()) == 2)
    by_accuracy = table(explorer)
    assert len(by_accuracy) == len(names)
    accuracies = [float(row.split()[-4]) for row in by_accuracy]
    assert accuracies == sorted(accuracies, reverse=True)
    explorer.choose("Sort by", "iterations")
    explorer.wait_until("another order", lambda: table(explorer) != by_accuracy)
    iterations = [int(row.split()[-1]) for row in table(explorer)]
    assert iterations == sorted(iterations)
    (row,) = [row for row in explorer.buttons() if "GMMReg, tuned" in row]
    explorer.press(row)
    explorer.wait_until("the method of the row", lambda: explorer.methods()[1] == "GMMReg, tuned")
    explorer.expect_to_agree()
    explorer.press("New seed")
    explorer.wait_until("that it is of another scene", lambda: explorer.says("The scene has changed since: compare"))


def table(explorer: UnseenExplorer) -> list[str]:
    """The rows of the comparison, from top to bottom."""
    return [text for text in explorer.buttons() if len(text) == len(COLUMNS) and text.split()[-1].isdigit()]


def test_an_own_method_is_shown_stepped_and_follows_the_scene(open_unseen: OpenUnseen):
    library = shipped_library().with_methods({PERSONAL: find_class(f"{EXAMPLE}:PointToPlane")})
    app = App(replace(AT_THE_START, left=PERSONAL), library=library, port=0)
    explorer = open_unseen(app=app)

    def agrees() -> bool:
        side, k = compute(explorer.state(), library).sides[0], explorer.iteration()
        numbers = {row: cells[0] for row, cells in explorer.numbers().items()}
        n = side.trajectory.iterations
        shown = (numbers["Iteration"], numbers["PointRMSE"], numbers["Rotation error"])
        return shown == (f"{k} / {n}", f"{side.scores.rmse[k]:.4f}", f"{side.scores.rotation[k]:.2f}°")

    explorer.wait_until("the method", agrees)
    assert PERSONAL in explorer.options("Right pane")
    for k in (1, 2):
        explorer.press("Next (N)")
        explorer.wait_until("the next iteration", lambda k=k: explorer.iteration() == k and agrees())
    explorer.drag("Rotation", 0.2)
    explorer.wait_until("the new scene", agrees)
    assert explorer.charts() == 2
    app.stop()


def test_a_researcher_finds_the_bin_that_misleads_most_in_a_failing_case(explorer: UnseenExplorer):
    explorer.press("Only Improved DO fails")
    explorer.wait_until("another scene", lambda: explorer.is_playing())
    explorer.press("Last")
    explorer.wait_until("the failing case", lambda: "wrong pose" in explorer.verdicts()[1])
    explorer.open_tab("Inspect")
    explorer.choose("Model colours", "towards the truth")
    explorer.wait_until("its colours", lambda: explorer.state().coloring == "towards the truth")

    run = independent_run(explorer.expect_to_agree())
    side, k = run.sides[1], run.sides[1].trajectory.iterations
    assert side.maps is not None
    h = side.histogram(run.scene.points, side.trajectory.x[k]).astype(np.float64)
    way = poses.log(run.scene.T_model_scene[None])[0] - side.trajectory.x[k]
    right = -(side.maps.maps[-1].astype(np.float64) * h).T @ (way / np.linalg.norm(way))
    block_side, point = bin_name(side.histogram, int(right.argmin()))
    worst = f"{point} {block_side} {right.min():+.4f}"

    explorer.wait_until("the worst first", lambda: explorer.options("Strongest bins")[1] == worst)
    explorer.choose("Strongest bins", worst)
    explorer.wait_until("its point", lambda: explorer.state().inspected == point)
    explorer.wait_until("its name in the picture", lambda: explorer.says(f"model point {point}"))
