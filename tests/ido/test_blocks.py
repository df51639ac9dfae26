"""The blocks: what they answer, that their compiled loops do so, and that their surfaces are where answers change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ido import HISTOGRAMS, Block, BlockHistogram, Cloud, Model, Perturbation, Question, SceneBatch, perturb, poses
from ido.blocks import SIGMA2, SMALLEST_WEIGHT

HISTOGRAMS_OF_BLOCKS = [kind for kind in HISTOGRAMS.values() if issubclass(kind, BlockHistogram)]
QUESTIONS = {block.name: block for kind in HISTOGRAMS_OF_BLOCKS for block in kind.blocks if isinstance(block, Question)}
EACH = pytest.mark.parametrize("question", QUESTIONS.values(), ids=QUESTIONS.keys())


def moved_scene(bunny: Cloud, seed: int = 0) -> np.ndarray:
    scene = perturb(bunny, Perturbation(points=150, outliers=50, seed=seed))
    return poses.transform(scene.T_model_scene, scene.points.astype(np.float64))


def test_the_shipped_histograms_ask_four_questions_in_four_colours():
    assert list(QUESTIONS) == ["front / back", "up / down", "clockwise / anticlockwise", "near / far"]
    assert len({question.color for question in QUESTIONS.values()}) == len(QUESTIONS)
    assert all(len(kind.blocks) == len(set(kind.blocks)) for kind in HISTOGRAMS_OF_BLOCKS)


def test_a_block_is_named_by_its_sides():
    block = Block("inside", "outside")
    assert (block.name, block.sides, block.color) == ("inside / outside", ("inside", "outside"), None)
    assert block == Block("inside", "outside") != Block("outside", "inside")


@pytest.mark.parametrize(
    ("name", "first"),
    [
        ("front / back", lambda m, n, s: n @ (s - m) > 0),
        ("up / down", lambda m, n, s: np.arctan2(s[2], np.hypot(*s[:2])) > np.arctan2(m[2], np.hypot(*m[:2]))),
        ("clockwise / anticlockwise", lambda m, n, s: np.arctan2(s[1], s[0]) > np.arctan2(m[1], m[0])),
        ("near / far", lambda m, n, s: np.linalg.norm(s - m) < np.sqrt(0.03)),
    ],
)
def test_answers_are_what_is_said_one_pair_after_another(small_model: Model, bunny: Cloud, name: str, first):
    points, normals = small_model.points.astype(np.float64), small_model.normals.astype(np.float64)
    moved = moved_scene(bunny)
    expected = [[first(m, n, s) for s in moved] for m, n in zip(points, normals, strict=True)]
    np.testing.assert_array_equal(QUESTIONS[name].answers(points, normals, moved), expected)


@pytest.mark.parametrize("name", ["front / back", "near / far"])
def test_weights_fall_with_the_distance_and_end(small_model: Model, bunny: Cloud, name: str):
    points, moved = small_model.points.astype(np.float64), moved_scene(bunny)
    squares = ((moved[None] - points[:, None]) ** 2).sum(axis=2)
    weights = QUESTIONS[name].weights(points, moved)
    near = squares < -np.log(SMALLEST_WEIGHT) * SIGMA2
    np.testing.assert_allclose(weights[near], np.exp(-squares[near] / SIGMA2))
    assert (weights[~near] == 0).all() and (~near).any()


@pytest.mark.parametrize("name", ["up / down", "clockwise / anticlockwise"])
def test_angles_count_every_point_alike(small_model: Model, bunny: Cloud, name: str):
    moved = moved_scene(bunny)
    assert (QUESTIONS[name].weights(small_model.points, moved) == 1).all()
    assert (QUESTIONS[name].sums(small_model, moved).sum(axis=0) == len(moved)).all()


@EACH
def test_what_one_point_says_adds_up_to_its_bins(question: Question, small_model: Model, bunny: Cloud):
    moved = moved_scene(bunny)
    sums = question.sums(small_model, moved)
    for point in (0, 7, len(small_model.points) - 1):
        first, counts = question.of_point(small_model, point, moved)
        np.testing.assert_allclose([counts[first].sum(), counts[~first].sum()], sums[:, point])


@EACH
def test_the_compiled_loop_counts_what_is_defined(question: Question, small_model: Model, bunny: Cloud):
    """Many scenes at once, an empty one among them, into the right place of a larger array."""
    scenes = [moved_scene(bunny, 1), np.zeros((0, 3)), moved_scene(bunny, 2)]
    starts = np.cumsum([0, *map(len, scenes)])
    compiled, defined = (np.full((3, 6, len(small_model.points)), -1, dtype=np.float32) for _ in range(2))
    question.count(question.layout(small_model), np.concatenate(scenes), starts, compiled, 2)
    Question.count(question, small_model, np.concatenate(scenes), starts, defined, 2)
    np.testing.assert_allclose(compiled, defined, rtol=1e-4, atol=1e-4)
    assert (compiled[:, [0, 1, 4, 5]] == -1).all()
    assert (compiled[1, 2:4] == 0).all()


@EACH
def test_points_that_are_not_finite_lead_no_loop_out_of_bounds(question: Question, small_model: Model, bunny: Cloud):
    moved = moved_scene(bunny)
    moved[::3], moved[1::7, 2] = np.nan, np.inf
    out = np.zeros((1, 2, len(small_model.points)), dtype=np.float32)
    question.count(question.layout(small_model), moved, np.array([0, len(moved)]), out, 0)
    if (question.weights(small_model.points, moved[:1]) == 1).all():  # every point counts, on one side or the other
        assert (out[0].sum(axis=0) == len(moved)).all()


@pytest.mark.parametrize("seed", range(4))
@EACH
def test_the_surface_is_where_the_answer_changes(question: Question, seed: int):
    """On the surface neither side is right; a little to its two sides the answers differ."""
    rng = np.random.default_rng(seed)
    m, n = rng.uniform(-0.8, 0.8, 3), Rotation.random(rng=rng).apply([0, 0, 1])
    surface = question.surface(m, n)
    assert surface.faces.max() < len(surface.vertices)
    corners = surface.vertices[surface.faces]
    centres = corners.mean(axis=1)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(across, axis=1)
    off = 0.02 * across / length[:, None]  # more than a flat face of a round surface is away from it
    clear = (length > 1e-9) & (np.linalg.norm(centres[:, :2], axis=1) > 0.1)  # angles are delicate at the axis
    one, other = (question.answers(m[None], n[None], (centres + step)[clear])[0] for step in (off, -off))
    assert clear.any()
    assert (one != other).mean() > 0.95
    assert surface.lines.shape[1:] == surface.guides.shape[1:] == (2, 3)


class Lower(Question):
    """A question that a researcher might add: nothing but its definition."""

    __slots__ = ()

    def __init__(self) -> None:
        super().__init__("lower", "higher")

    def answers(self, points: np.ndarray, normals: np.ndarray, moved: np.ndarray) -> np.ndarray:
        return moved[None, :, 2] < points[:, None, 2]

    def weights(self, points: np.ndarray, moved: np.ndarray) -> np.ndarray:
        return np.ones((len(points), len(moved)))

    def surface(self, point: np.ndarray, normal: np.ndarray):
        return QUESTIONS["front / back"].surface(point, np.array([0.0, 0.0, 1.0]))


class LowerAndNear(BlockHistogram):
    """It stands beside a compiled one."""

    name = "lower-and-near"
    blocks = (Lower(), QUESTIONS["near / far"])


def test_a_question_without_a_compiled_loop_stands_beside_one_that_has_one(small_model: Model, bunny: Cloud):
    histogram = LowerAndNear(small_model)
    assert histogram.side_names == ("lower", "higher", "near", "far")
    scene = perturb(bunny, replace(Perturbation(), seed=3))
    x = np.array([0.1, 0, 0, 0, 0, 0.4])
    defined = histogram.describe(poses.transform(poses.exp(x), scene.points.astype(np.float64)))
    np.testing.assert_allclose(histogram(scene.points, x), defined, atol=1e-4)
    batch = histogram.batch(SceneBatch.of([scene.points] * 9), np.stack([x] * 9))
    np.testing.assert_array_equal(batch[8], histogram(scene.points, x))
