"""What a click into the 3D view meets."""

from __future__ import annotations

import numpy as np
import pytest

from ido import Perturbation
from ido_viz.canvas.canvas import point_at
from ido_viz.canvas.pane import PANE_OFFSETS
from ido_viz.core.geometry import VIEW_DIRECTION, upright
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.core.state import State

BEGIN = State(perturbation=Perturbation(points=100), max_iterations=1, playing=False)
PLACES = np.array([[x, 0.0, 0.0] for x in PANE_OFFSETS])
EYE = 6.0 * VIEW_DIRECTION / np.linalg.norm(VIEW_DIRECTION)


@pytest.mark.parametrize("shape", ["bunny", "urban"])
@pytest.mark.parametrize("pane", ["left", "right"])
def test_a_click_on_what_is_seen_of_a_model_picks_a_point_of_it_nearby(shape: str, pane: str):
    library = shipped_library()
    run = compute(library.at_shape(BEGIN, shape), library)
    place = PLACES[int(pane == "right")]
    turn = upright(run.subject.up)
    cloud = turn.apply(run.subject.cloud().points) + place
    model = turn.apply(run.sides[0].histogram.model.points) + place
    picked, near = [], []
    for point in np.random.default_rng(0).choice(cloud, 400, replace=False):
        ray = (point - EYE) / np.linalg.norm(point - EYE)
        along = (cloud - EYE) @ ray
        beside = np.linalg.norm(cloud - EYE - along[:, None] * ray, axis=1)
        if ((beside < 0.02) & (along < (point - EYE) @ ray - 0.1)).any():
            continue  # something stands before it
        found = point_at(run, EYE, ray, PLACES)
        picked.append(found is not None and found[0] == pane)
        if found is not None:
            near.append(np.linalg.norm(model[found[1]] - point) < 0.2)
    assert len(picked) > 100
    assert np.mean(picked) > 0.98
    assert np.mean(near) > 0.7


def test_a_click_beside_both_models_picks_nothing():
    run = compute(BEGIN, shipped_library())
    assert point_at(run, EYE, np.array([0.0, 0.0, 2.0]) - EYE, PLACES) is None
