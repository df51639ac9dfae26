"""Looking into a method: shares, a model point's answers, and picking it by a click."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from ido import Perturbation, poses
from ido.blocks import SIGMA2, azimuth, elevation
from ido_viz.canvas.pane import answer_colors
from ido_viz.core.geometry import point_on_ray
from ido_viz.core.inspection import Inspection, inspect, inspected_number
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute
from ido_viz.core.state import State, decode, encode
from ido_viz.panels.inspect_tab import bin_label, pair_table, tables_html

STATE = State(perturbation=Perturbation(seed=2), iteration=2, inspected=100, coloring="whole update")


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(STATE, shipped_library())


def looked_into(run: Run, state: State, iteration: int) -> Inspection:
    found = inspect(run, state, iteration, inspected_number(state))
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
    assert inspect(baseline, STATE, 2, 1) is None
    assert looked_into(baseline, replace(STATE, inspected_pane="left"), 2).side.method == "DO"


def test_the_question_is_the_histograms_block_of_that_name(run: Run) -> None:
    for name in ("front / back", "up / down", "clockwise / anticlockwise"):
        inspection = looked_into(run, replace(STATE, question=name), 2)
        question = inspection.question
        assert question is not None and question.name == name
        first, counts = question.of_point(inspection.side.histogram.model, 100, inspection.moved)
        assert inspection.answers is not None
        np.testing.assert_array_equal(inspection.answers[0], first)
        np.testing.assert_array_equal(inspection.answers[1], counts)
    assert looked_into(run, replace(STATE, question="near / far"), 2).question is None
    of_do = looked_into(run, replace(STATE, inspected_pane="left", question="up / down"), 2)
    assert of_do.question is None and of_do.answers is None
    assert looked_into(run, replace(STATE, inspected=-1), 2).answers is None


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


def test_points_that_count_less_are_paler() -> None:
    first, counts = np.array([True, True, False]), np.array([1.0, 0.1, 1.0])
    colors = answer_colors(first, counts, (0, 158, 115), dark=False).astype(int)
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


def columns(table: str) -> tuple[list[str], set[str]]:
    """The heads of the first table, and which columns are marked in every row of it."""
    table = table[: table.index("</table>")]
    heads = re.findall(r"<th style=\"([^\"]*)\">([^<]*)</th>", table)
    rows = [re.findall(r"<td style=\"([^\"]*)\">", row) for row in re.findall(r"<tr>(.*?)</tr>", table)][1:]
    marked = {name for i, (_, name) in enumerate(heads) if all("background" in row[i] for row in rows)}
    assert marked == {name for style, name in heads if "background" in style}
    return [name for _, name in heads], marked


def test_the_table_marks_what_the_model_s_colours_show_and_has_it_once(run: Run) -> None:
    for coloring, extra, marked in (
        ("φz", [], {"φz"}),
        ("whole update", ["along it"], {"along it"}),
        ("height", ["along it"], set()),
    ):
        state = replace(STATE, coloring=coloring)
        content = tables_html(looked_into(run, state, 2), state)
        assert columns(content) == (["", *extra, *poses.PARAMETERS], marked)


def test_what_is_looked_into_is_in_the_code() -> None:
    state = replace(STATE, question="up / down", against_reference=True, inspected_pane="left", coloring="φz")
    assert decode(encode(state)) == state


@pytest.mark.parametrize("iteration", [0, 4])
def test_the_shares_towards_the_truth_add_up_to_how_far_the_update_goes_the_right_way(iteration: int, run: Run) -> None:
    whole = looked_into(run, replace(STATE, coloring="towards the truth"), iteration)
    x = run.sides[1].trajectory.x
    way = poses.log(run.scene.T_model_scene[None])[0] - x[iteration]
    made = (x[iteration + 1] - x[iteration]) @ way / np.linalg.norm(way)
    assert np.isclose(whole.values.sum(), made, atol=1e-6)
    misleading = whole.values[whole.strongest]
    assert (misleading < 0).all() and (np.diff(misleading) >= 0).all()
    assert misleading[0] == whole.values.min()


def test_a_pair_of_points_answers_as_the_bins_add_up(run: Run) -> None:
    """The table's answers, by the definition, of a scene point near a model point."""
    whole = looked_into(run, STATE, 2)
    model = whole.side.histogram.model
    one = int(np.argmin(((whole.moved - model.points[100]) ** 2).sum(axis=1)))
    pair = looked_into(run, replace(STATE, scene_point=one), 2)
    offset = pair.moved[one] - model.points[100].astype(np.float64)
    weight = np.exp(-(offset @ offset) / SIGMA2)
    answer = "front" if offset @ model.normals[100] > 0 else "back"
    side = ("front", "back").index(answer)
    total = pair.side.histogram.sides(pair.moved)[side, 100]  # type: ignore[attr-defined]
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", pair_table(pair))
    assert cells[:3] == ["front / back", answer, f"{weight:.4f}"]
    assert float(cells[3].strip("%")) == pytest.approx(100 * weight / total, abs=0.02)
    assert cells[5] == ("up" if elevation(pair.moved)[one] > elevation(model.points)[100] else "down")
    assert cells[9] == ("clockwise" if azimuth(pair.moved)[one] > azimuth(model.points)[100] else "anticlockwise")
    assert cells[12:] == ["its distance", "", f"{np.linalg.norm(offset):.3f}", ""]
    assert looked_into(run, replace(STATE, scene_point=10_000), 2).scene_point is None
    assert f"scene point {one}" in tables_html(pair, STATE)
