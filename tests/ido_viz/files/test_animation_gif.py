"""The animation for slides shows what the page shows: the right colours in the right places at the right times."""

from __future__ import annotations

import io
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from ido import Perturbation, poses
from ido_viz.core import palette
from ido_viz.core.frame import frame_of
from ido_viz.core.geometry import VIEW_DIRECTION
from ido_viz.core.library import shipped_library
from ido_viz.core.pacing import Pacing
from ido_viz.core.palette import Color
from ido_viz.core.run import Run, compute
from ido_viz.core.state import State
from ido_viz.files import animation_gif as slides
from ido_viz.files.animation_gif import HOLD, MOST_FRAMES, SIZE, animation_gif
from ido_viz.files.projection import Dots, View

LIBRARY = shipped_library()
EASY = Perturbation(points=200, outliers=40, noise=0.0, incomplete=0.0, rotation=40.0, translation=0.5, seed=3)
STATE = State(perturbation=EASY, speed=20, max_iterations=8)
STILL = replace(STATE, left="Did nothing", right="Did nothing")
COLORS = [palette.method_color(name) for name in (STATE.left, STATE.right)]
WIDTH = SIZE[0] // 2
TITLES, PANES = slice(0, 110), slice(125, 630)
"""Rows of a frame."""

Frames = list[np.ndarray]


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(STATE, LIBRARY)


def decoded(content: bytes) -> tuple[Frames, list[int]]:
    """All frames of a GIF, each of shape (height, width, 3), and how many milliseconds each is shown."""
    picture = Image.open(io.BytesIO(content))
    assert (picture.format, picture.size) == ("GIF", SIZE)
    frames, durations = [], []
    for number in range(getattr(picture, "n_frames", 1)):
        picture.seek(number)
        durations.append(picture.info.get("duration", 0))
        frames.append(np.asarray(picture.convert("RGB")))
    return frames, durations


@pytest.fixture(scope="module")
def content(run: Run) -> bytes:
    return animation_gif(frame_of(run, STATE))


@pytest.fixture(scope="module")
def shown(content: bytes) -> tuple[Frames, list[int]]:
    return decoded(content)


def still(state: State) -> np.ndarray:
    """The only frame of a run that does nothing."""
    frames, _ = decoded(animation_gif(frame_of(compute(state, LIBRARY), state)))
    assert len(frames) == 1
    return frames[0]


def halves(frame: np.ndarray, rows: slice) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the left and the right pane, without the columns next to the line between them."""
    return frame[rows, 1 : WIDTH - 1], frame[rows, WIDTH + 1 : -1]


def places(part: np.ndarray, color: Color) -> np.ndarray:
    """Column and row of the pixels of a colour, shape (n, 2)."""
    return np.argwhere((part == np.array(color)).all(axis=2))[:, ::-1]


# What is shown when


def test_it_is_played_at_the_pace_of_the_page_and_the_ends_are_held(run: Run, shown: tuple[Frames, list[int]]):
    _, durations = shown
    assert durations[0] == durations[-1] == HOLD
    (each,) = set(durations[1:-1])
    seconds = Pacing(run).times[-1] * 15 / STATE.speed
    assert (len(durations) - 1) * each == pytest.approx(1000 * seconds, abs=5 * len(durations))


def test_every_iteration_is_shown_and_the_scenes_move_in_between(run: Run, shown: tuple[Frames, list[int]]):
    frames, _ = shown
    assert len({frame[TITLES].tobytes() for frame in frames}) == run.iterations + 1
    for before, after in pairwise(frames):
        for old, new in zip(halves(before, PANES), halves(after, PANES), strict=True):
            assert (old != new).any()


def test_it_loops_and_says_what_it_is(content: bytes):
    info = Image.open(io.BytesIO(content)).info
    assert info["loop"] == 0
    assert info["comment"].decode().startswith("DO and Improved DO on bunny, seed 3: rotation 40°")


@pytest.mark.parametrize("speed", [1, 15, 60])
def test_a_faster_page_makes_a_shorter_animation(run: Run, monkeypatch: pytest.MonkeyPatch, speed: int):
    monkeypatch.setattr(slides, "MOST_FRAMES", 3)
    start, middle, end = decoded(animation_gif(frame_of(run, replace(STATE, speed=speed))))[1]
    assert start == end == HOLD
    assert 2 * middle == pytest.approx(1000 * Pacing(run).times[-1] * 15 / speed, abs=10)
    assert 60 <= MOST_FRAMES <= 100


def test_a_long_run_keeps_its_first_iteration_and_its_last(
    run: Run, shown: tuple[Frames, list[int]], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(slides, "MOST_FRAMES", 6)
    frames, durations = decoded(animation_gif(frame_of(run, STATE)))
    assert len(frames) == 6
    for end in (0, -1):
        np.testing.assert_array_equal(frames[end][TITLES], shown[0][end][TITLES])
    assert sum(durations) == pytest.approx(sum(shown[1]), rel=0.2)


# What is where


def test_the_scene_moves_to_where_it_belongs(run: Run, shown: tuple[Frames, list[int]]):
    first, last = shown[0][0], shown[0][-1]
    for pane, side in enumerate(run.sides):
        assert side.scores.rmse[-1] < 0.2 * side.scores.rmse[0]
        target = places(halves(first, PANES)[pane], palette.GHOST).mean(axis=0)
        start, end = (places(halves(frame, PANES)[pane], COLORS[pane]).mean(axis=0) for frame in (first, last))
        assert np.linalg.norm(end - target) < 0.3 * np.linalg.norm(start - target)


def test_what_is_the_same_in_both_panes_is_drawn_in_the_same_place():
    left, right = halves(still(STILL), PANES)
    for color in (palette.OUTLIER, palette.GHOST):
        of_left, of_right = ({tuple(place) for place in places(part, color)} for part in (left, right))
        assert len(of_left) > 50
        assert len(of_left ^ of_right) < 0.1 * len(of_left)  # edges blend with the panes' own colours


def test_each_pane_has_its_own_colour_and_an_overlay_adds_the_others(
    run: Run, shown: tuple[Frames, list[int]], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(slides, "MOST_FRAMES", 3)
    overlaid = decoded(animation_gif(frame_of(run, replace(STATE, overlay="other method"))))[0][1]
    for pane, (plain, over) in enumerate(zip(halves(shown[0][-1], PANES), halves(overlaid, PANES), strict=True)):
        assert len(places(plain, COLORS[pane])) > 500
        assert len(places(plain, COLORS[1 - pane])) == 0
        assert len(places(over, COLORS[1 - pane])) > 100


def test_where_it_belongs_and_error_vectors_are_shown_only_on_request():
    plain = len(places(still(STILL), palette.GHOST))
    assert len(places(still(replace(STILL, error_vectors=True)), palette.GHOST)) > plain > 100
    assert len(places(still(replace(STILL, ghost=False)), palette.GHOST)) == 0


@pytest.mark.parametrize("dark", [False, True])
def test_the_page_is_light_or_dark_and_has_few_colours(dark: bool):
    frame = still(replace(STILL, dark=dark))
    assert frame[0, 0].tolist() == ([30] * 3 if dark else [255] * 3)
    assert len({*map(tuple, frame[::3, ::2].reshape(-1, 3).tolist())}) <= 64


def test_scores_that_a_lecturer_has_hidden_are_not_shown():
    for hidden, expected in (((), True), (("scores",), False)):
        frame = still(replace(STILL, hidden=hidden))
        for part in halves(frame, slice(90, 114)):
            assert bool(len(places(part, palette.ink(dark=False)))) == expected


@pytest.mark.parametrize("large", [False, True])
def test_titles_keep_their_size_and_place_from_frame_to_frame(run: Run, large: bool, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(slides, "MOST_FRAMES", run.iterations + 1)
    state = replace(STATE, large_text=large)
    heights = set()
    for frame in decoded(animation_gif(frame_of(run, state)))[0]:
        rows = places(halves(frame, slice(60, 116))[0], palette.ink(dark=False))[:, 1]
        heights.add((rows.min(), rows.max()))
    assert len(heights) == 1


@pytest.mark.parametrize("name", ["W" * 200, "two\nlines", "<b>$x$</b>"])
def test_a_name_is_drawn_in_its_own_half_in_one_line(name: str):
    run = compute(STILL, LIBRARY)
    named = replace(run, sides=(replace(run.sides[0], method=name), run.sides[1]))
    frame = decoded(animation_gif(frame_of(named, STILL)))[0][0]
    left, right = halves(frame, TITLES)
    own = places(left, palette.method_color(name))
    assert len(own) > 50
    assert own[:, 0].min() >= 10
    assert own[:, 0].max() <= WIDTH - 10
    assert np.ptp(own[:, 1]) < 45
    assert len(places(right, palette.method_color(name))) == 0


def test_even_a_long_animation_is_small_enough_for_mail(monkeypatch: pytest.MonkeyPatch):
    few = 10  # far apart, so that each differs more from the last than in a long one
    monkeypatch.setattr(slides, "MOST_FRAMES", few)
    run = compute(State(), LIBRARY)
    assert len(animation_gif(frame_of(run, State()))) / few * MOST_FRAMES < 5e6


# The projection, against a pinhole camera


@pytest.mark.parametrize("shape", LIBRARY.subjects)
def test_the_view_is_a_pinhole_cameras_from_the_canvass_direction(shape: str):
    up = LIBRARY.subject(shape).up
    rng = np.random.default_rng(0)
    points = rng.uniform(-1, 1, (50, 3))
    view = View.over(points, up, (640, 480))
    found, scales = view.project(points)

    turned = points @ view.turn.T
    eye = np.array([0.0, 0.0, 5.0])
    ray = turned - eye
    on_plane = eye + ray * (-eye[2] / ray[:, 2])[:, None]  # where the ray to the eye meets the centre's plane
    expected = (on_plane[:, :2] - view.centre) * [view.scale, -view.scale] + [319.5, 239.5]
    np.testing.assert_allclose(found, expected)
    np.testing.assert_allclose(scales, view.scale * 5 / np.linalg.norm(ray * [0, 0, 1], axis=1))

    np.testing.assert_allclose(view.turn @ view.turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(view.turn) == pytest.approx(1)
    steepness = VIEW_DIRECTION[2] / np.linalg.norm(VIEW_DIRECTION)
    np.testing.assert_allclose(view.turn @ up, [0, np.sqrt(1 - steepness**2), steepness], atol=1e-6)
    assert (found >= 0).all()
    assert (found <= [639, 479]).all()


def test_points_beside_or_behind_the_eye_are_not_drawn():
    view = View.over(np.random.default_rng(0).uniform(-1, 1, (50, 3)), (0.0, 0.0, 1.0), (60, 40))
    page = np.zeros((40, 60), dtype=np.uint8)
    astray = np.array([[0.0, 0, 4.9], [0, 0, 50], [80, 0, 0], [0, -80, 0]]) @ view.turn
    drawn = view.stamp(page, [Dots(astray, np.ones(4), 0.1)])
    np.testing.assert_array_equal(drawn, page)


def test_discs_are_drawn_as_one_by_one_from_the_farthest_to_the_nearest():
    rng = np.random.default_rng(1)
    points, colors = rng.uniform(-1, 1, (300, 3)), rng.integers(1, 9, 300)
    view = View.over(points, (0.0, 0.0, 1.0), (90, 70))
    layers = [Dots(points[:200], colors[:200], 0.05), Dots(points[200:], colors[200:], 0.08, rim=1.5, ahead=0.3)]
    radius, rim, ahead = (np.repeat([few, many], [200, 100]) for few, many in ((0.05, 0.08), (0, 1.5), (0, 0.3)))
    spots, scales = view.project(points)
    y, x = np.mgrid[:70, :90]
    expected = np.full((70, 90), 9, dtype=np.uint8)
    for i in np.argsort(scales * (1 + ahead / 5)):
        if (spots[i] > -0.5).all() and (spots[i] < [89.5, 69.5]).all():
            away = np.hypot(x - spots[i, 0], y - spots[i, 1])
            expected[away <= radius[i] * scales[i] + rim[i]] = 0
            expected[away <= radius[i] * scales[i]] = colors[i]
    drawn = view.stamp(np.full((70, 90), 9, dtype=np.uint8), layers)
    assert (drawn != expected).mean() < 1e-3  # rounding at the edges


def test_everything_stays_in_sight(run: Run):
    moved = [poses.transform(T, run.scene.points) for side in run.sides for T in side.T_model_scene]
    points = np.concatenate(moved)
    spots, _ = View.over(points, run.subject.up, (600, 300)).project(np.clip(points, -1.8, 1.8))
    assert (spots.min(axis=0) >= 0).all()
    assert (spots.max(axis=0) <= [599, 299]).all()
