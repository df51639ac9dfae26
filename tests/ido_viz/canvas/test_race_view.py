"""Where the darts of a race fly."""

from __future__ import annotations

import numpy as np
import pytest

from ido import poses
from ido_viz.canvas.race_view import darts
from ido_viz.core.geometry import upright
from ido_viz.core.race import Race

CHOSEN = poses.exp(np.array([0.3, -0.2, 0.1, 0.5, 1.0, -2.0]))


def race_of(*T_model_scene: np.ndarray) -> Race:
    """A race without a step, of starts at these poses."""
    n = len(T_model_scene)
    return Race(np.stack(T_model_scene)[:, None], np.full(n, 1), np.zeros((n, 1)))


@pytest.mark.parametrize("up", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0)])
def test_the_chosen_start_is_over_the_top_and_points_to_the_front(up: tuple[float, float, float]):
    (dart,) = darts(race_of(CHOSEN), CHOSEN, up)[:, 0]
    shown = upright(up).apply(dart[:3, 3])  # as the pane turns it
    assert np.allclose(shown[:2], 0) and shown[2] > 1
    assert np.allclose(upright(up).as_matrix() @ dart[:3, :3], np.eye(3))


def test_a_start_that_is_turned_away_flies_as_far_away():
    turned = poses.exp(np.array([0.0, 0.0, 0.0, np.pi / 2, 0.0, 0.0]))  # about the model's x
    first, second = darts(race_of(CHOSEN, turned @ CHOSEN), CHOSEN, (0.0, 0.0, 1.0))[:, 0]
    assert np.allclose(second, turned @ first)
    assert np.isclose(np.linalg.norm(second[:3, 3] - first[:3, 3]), np.sqrt(2) * first[2, 3])
