"""What people come for, from the opened page on: a researcher who asks what misleads a method."""

from __future__ import annotations

import numpy as np
from explorer import Explorer, independent_run

from ido import poses
from ido.attribution import bin_name


def test_a_researcher_finds_the_bin_that_misleads_most_in_a_failing_case(explorer: Explorer):
    explorer.press("Only Improved DO fails")
    explorer.wait_until("another scene", lambda: explorer.is_playing())
    explorer.press("Last")
    explorer.wait_until("the failing case", lambda: "wrong pose" in explorer.verdicts()[1])
    explorer.open_tab("Inspect")
    explorer.choose("Model colours", "towards the truth")
    explorer.wait_until("its shares", lambda: explorer.state().coloring == "towards the truth")
    worst = explorer.options("Strongest bins")[1]
    explorer.choose("Strongest bins", worst)
    explorer.wait_until("its point", lambda: explorer.state().inspected >= 0)
    state = explorer.expect_to_agree()

    run = independent_run(state)
    side, k = run.sides[1], run.sides[1].trajectory.iterations
    assert side.maps is not None
    h = side.histogram(run.scene.points, side.trajectory.x[k]).astype(np.float64)
    way = poses.log(run.scene.T_model_scene[None])[0] - side.trajectory.x[k]
    right = -(side.maps.maps[-1].astype(np.float64) * h).T @ (way / np.linalg.norm(way))
    block_side, point = bin_name(side.histogram, int(right.argmin()))
    assert worst == f"{point} {block_side} {right.min():+.4f}"
    assert state.inspected == point
    explorer.page.get_by_text(f"model point {point}", exact=True).wait_for()
