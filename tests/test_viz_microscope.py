"""Looking into a method: shares, a model point's answers, and picking it by a click."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ido import Perturbation, shipped_maps
from ido.histograms import azimuth, elevation
from ido_viz.canvas import answer_colors
from ido_viz.diagram import cone, disc, half_plane
from ido_viz.inspect_panel import bin_label, tables_html
from ido_viz.library import shipped_library
from ido_viz.microscope import Inspection, answers, asked, inspect, point_on_ray
from ido_viz.run import Run, compute
from ido_viz.state import State, decode, encode

STATE = State(perturbation=Perturbation(seed=2), iteration=2, inspected=100, coloring="whole update")


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(STATE, shipped_library())


def looked_into(run: Run, state: State, iteration: int) -> Inspection:
    found = inspect(run, state, iteration)
    assert found is not None
    return found


@pytest.mark.parametrize("pane", ["left", "right"])
@pytest.mark.parametrize("iteration", [0, 2, 29])
def test_the_shares_add_up_to_the_update_shown(pane: str, iteration: int, run: Run) -> None:
    state = replace(STATE, inspected_pane=pane)
    side = run.sides[("left", "right").index(pane)]
    made = side.trajectory.x[iteration + 1] - side.trajectory.x[iteration]
    whole = looked_into(run, state, iteration)
    assert np.isclose(whole.values.sum(), side.trajectory.update_norms[iteration], atol=1e-6)
    assert np.isclose(whole.of_points.sum(), whole.values.sum())
    one = looked_into(run, replace(state, coloring="φy"), iteration)
    assert np.isclose(one.values.sum(), made[4], atol=1e-6)


def test_a_baseline_has_nothing_to_look_into(run: Run) -> None:
    baseline = compute(replace(STATE, right="ICP, tuned"), shipped_library())
    assert inspect(baseline, STATE, 2) is None
    assert looked_into(baseline, replace(STATE, inspected_pane="left"), 2).side.method == "DO"


def test_a_points_answers_add_up_to_its_bins(run: Run) -> None:
    histogram = shipped_maps("bunny", "triple-binary").histogram
    whole = looked_into(run, STATE, 2)
    sides = histogram.sides(whole.moved)  # type: ignore[attr-defined]
    for row, question in enumerate(("front / back", "up / down", "clockwise / anticlockwise")):
        assert asked(histogram, question)
        for point in (0, 100, 513):
            first, counts = answers(histogram, whole.moved, point, question)
            assert np.isclose(counts[first].sum(), sides[2 * row, point], rtol=1e-3, atol=1e-3)
            assert np.isclose(counts[~first].sum(), sides[2 * row + 1, point], rtol=1e-3, atol=1e-3)
    assert not asked(shipped_maps("bunny", "front-back").histogram, "up / down")


def test_an_unknown_point_is_none(run: Run) -> None:
    assert looked_into(run, replace(STATE, inspected=-1), 2).point is None
    assert looked_into(run, replace(STATE, inspected=5000), 2).point is None
    assert looked_into(run, STATE, 2).point == 100


def test_a_ray_meets_the_nearest_point_on_its_way() -> None:
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.0, 1, 0], [0.0, 0, -5]])
    assert point_on_ray(points, np.array([0.0, 0, 5]), np.array([0.0, 0, -2]), 0.05) == 0  # before the one behind it
    assert point_on_ray(points, np.array([1.02, 0, 5]), np.array([0.0, 0, -1]), 0.05) == 1
    assert point_on_ray(points, np.array([0.5, 0.5, 5]), np.array([0.0, 0, -1]), 0.05) is None
    assert point_on_ray(points, np.array([0.0, 0, 5]), np.array([0.0, 0, 1]), 0.05) is None


@pytest.mark.parametrize("seed", range(4))
def test_the_diagram_is_where_the_answers_change(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = rng.uniform(-0.8, 0.8, 3), Rotation.random(rng=rng).apply([0, 0, 1])
    vertices, faces = disc(m, n)
    assert np.allclose((vertices - m) @ n, 0)
    assert faces.max() < len(vertices)
    vertices, _ = cone(m)
    assert np.allclose(elevation(vertices[1:]), elevation(m[None]))
    vertices, _ = half_plane(m)
    off_axis = np.hypot(vertices[:, 0], vertices[:, 1]) > 1e-6
    assert np.allclose(azimuth(vertices[off_axis]), azimuth(m[None]))


def test_points_that_count_less_are_paler() -> None:
    colors = answer_colors(np.array([True, True, False]), np.array([1.0, 0.1, 1.0]), "up / down", dark=False).astype(
        int
    )
    assert colors[1].min() > colors[0].min()
    assert not np.array_equal(colors[0], colors[2])


def test_the_tables_hold_the_bins_and_the_strongest_are_the_largest(run: Run) -> None:
    whole = looked_into(run, STATE, 2)
    content = tables_html(whole, STATE)
    for name in ("front", "back", "up", "down", "clockwise", "anticlockwise", "model point 100"):
        assert name in content
    assert f"{whole.seen[100]:.4f}" in content
    assert f"{whole.values.sum():+.4f}" in content
    values = np.abs(whole.values[whole.strongest])
    assert (np.diff(values) <= 0).all()
    assert values[-1] >= np.sort(np.abs(whole.values))[-12]
    assert bin_label(whole, 100).startswith("100 front ")


def test_what_is_looked_into_is_in_the_code() -> None:
    state = replace(STATE, question="up / down", against_reference=True, inspected_pane="left", coloring="φz")
    assert decode(encode(state)) == state
