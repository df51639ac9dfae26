"""The camera of a page without a browser: where it looks from, and what it tells of a person who moves it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from itertools import product
from typing import Any, cast

import numpy as np
import pytest
import viser
from scipy.spatial.transform import Rotation

from ido.types import DoubleArray
from ido_viz.canvas.camera import _FITTED, Camera
from ido_viz.canvas.pane import PANE_OFFSETS
from ido_viz.core.state import NO_CAMERA, State

ELSEWHERE = (0.3, -0.7, 0.5, 0.1, -0.2, 0.3)
WINDOWS = (0.46, 0.8, 1.0, 1.6, 2.4)
"""Width of a canvas by its height."""


class Window:
    """Stands for a page's camera, and for a person who moves it; what it tells is noted."""

    def __init__(self, aspect: float) -> None:
        self.aspect, self.fov = aspect, 0.87
        self._position, self.look_at = np.array([3.0, 3.0, 3.0]), np.zeros(3)
        self.sent: list[DoubleArray] = []
        self.update_timestamp = 1.0
        self.told: list[tuple[float, ...]] = []
        self.turned: list[DoubleArray] = []
        self._update: Callable[[Any], None] = print
        self.camera = Camera(cast(viser.CameraHandle, self), self.told.append, self.turned.append)

    @property
    def position(self) -> DoubleArray:
        return self._position

    @position.setter
    def position(self, position: DoubleArray) -> None:
        if not np.allclose(position, self._position):  # as viser does it
            self._position = position
            self.sent.append(position)

    @property
    def wxyz(self) -> DoubleArray:
        """Of a camera without roll: its x axis to the right, its z axis to what it looks at."""
        forward = self.look_at - self.position
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(forward, right), forward], axis=1)
        return Rotation.from_matrix(axes).as_quat(scalar_first=True)

    def on_update(self, update: Callable[[Any], None]) -> None:
        self._update = update

    def tell(self) -> None:
        """The page tells where its camera is."""
        self.update_timestamp += 1.0
        self._update(None)

    def tell_late(self) -> None:
        """What the page told before is taken note of only now."""
        self._update(None)

    def orbit(self, x: float, y: float, z: float) -> None:
        """A person moves the camera, and the page tells of it."""
        self.position = np.array([x, y, z])
        self.tell()


def opened(aspect: float, place: tuple[float, ...] = NO_CAMERA) -> Window:
    """A window that shows what it was sent."""
    window = Window(aspect)
    window.camera.begin(place)
    window.tell()
    return window


@pytest.mark.parametrize("aspect", WINDOWS)
def test_both_panes_are_seen_whole_in_any_window(aspect: float):
    window = opened(aspect)
    forward = window.look_at - window.position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    for offset, x, z in product(PANE_OFFSETS, (-1, 1), (-1, 1)):
        ray = np.array([offset + x, 0.0, z]) - window.position
        high = ray @ up / (ray @ forward) / np.tan(window.fov / 2)
        assert abs(high) < 1
        assert abs(ray @ right / (ray @ forward) / np.tan(window.fov / 2) / aspect) < 1


@pytest.mark.parametrize("place", [NO_CAMERA, ELSEWHERE])
def test_a_page_that_arrives_where_it_was_sent_does_not_move(place: tuple[float, ...]):
    window = opened(1.5, place)
    window.tell()
    assert window.told == []


def test_what_a_page_tells_on_its_way_is_no_move():
    window = Window(1.5)
    window.tell()
    window.camera.begin(ELSEWHERE)
    there, window.position = window.position, np.array([3.0, 3.0, 3.0])
    window.tell()
    assert window.told == []
    window.position = there
    window.tell()
    assert window.told == []


def test_the_place_that_is_sent_is_not_taken_for_the_page_s_word():
    window = Window(1.5)
    window.camera.begin(ELSEWHERE)
    there = window.position
    window.tell_late()
    window.position = np.array([3.0, 3.0, 3.0])  # the page has told of it before it got the new one
    window.tell()
    assert window.told == []
    window.position = there
    window.tell()
    window.orbit(1.0, 2.0, 3.0)
    assert len(window.told) == 1


@pytest.mark.parametrize("one", WINDOWS)
@pytest.mark.parametrize("other", WINDOWS)
def test_what_is_told_gives_the_same_view_in_a_window_of_another_shape(one: float, other: float):
    window = opened(one)
    window.orbit(2.0, -3.0, 1.0)
    (place,) = window.told
    assert State(camera=place).camera == place
    shown = opened(other, place)
    assert shown.told == []
    way, shown_way = (
        (each.position - each.look_at) / np.linalg.norm(each.position - each.look_at) for each in (window, shown)
    )
    np.testing.assert_allclose(shown_way, way, atol=2e-3)
    if one == other:
        np.testing.assert_allclose(shown.position, window.position, atol=0.02)


def test_of_moves_that_come_at_once_one_waits_and_the_newest_is_told(monkeypatch: pytest.MonkeyPatch):
    window, waiting = opened(1.5), threading.Semaphore(0)
    goes_on = threading.Event()
    monkeypatch.setattr("ido_viz.canvas.camera.time.sleep", lambda _: (waiting.release(), goes_on.wait(10)))
    first = threading.Thread(target=window.orbit, args=(1.0, -4.0, 1.0))
    first.start()
    assert waiting.acquire(timeout=10)
    for step in range(20):
        window.orbit(1.0 + 0.1 * step, -4.0, 1.0)  # returns at once
    assert not waiting.acquire(blocking=False)
    goes_on.set()
    first.join()
    assert len(window.told) == 1
    other = opened(1.5)
    other.orbit(2.9, -4.0, 1.0)
    assert window.told == other.told


def test_the_newest_place_is_told_last_though_who_is_told_was_busy_with_an_older_one():
    window, busy, goes_on = opened(1.5), threading.Event(), threading.Event()
    told: list[tuple[float, ...]] = []

    def take(place: tuple[float, ...]) -> None:
        if not busy.is_set():
            busy.set()
            assert goes_on.wait(10)
        told.append(place)

    window.camera = Camera(cast(viser.CameraHandle, window), take, window.turned.append)
    window.camera.begin(NO_CAMERA)
    window.tell()
    first = threading.Thread(target=window.orbit, args=(1.0, -4.0, 1.0))
    first.start()
    assert busy.wait(10)
    window.orbit(2.0, -4.0, 1.0)
    window.orbit(2.9, -4.0, 1.0)
    goes_on.set()
    first.join()
    other = opened(1.5)
    other.orbit(2.9, -4.0, 1.0)
    assert told[-1] == other.told[-1]
    window.orbit(2.0, -4.0, 1.0)
    assert told[-1] != other.told[-1], "nobody tells any more"


def test_frames_that_a_person_has_overtaken_do_not_turn_the_view_back():
    window = opened(1.5)
    for step in range(4):
        window.orbit(1.0 + 0.3 * step, -4.0, 1.0)
        window.camera.begin(NO_CAMERA)
    np.testing.assert_array_equal(window.position, [1.9, -4.0, 1.0])
    assert len(window.told) == 4


def test_a_place_that_the_page_left_is_sent_again_though_it_told_of_it_just_now():
    window = opened(0.8)
    narrow = window.position
    window.aspect = 1.3
    window.tell()
    wide = window.position
    assert not np.allclose(wide, narrow)
    window.aspect = 0.8
    window._position = narrow  # told before the other place came there
    window.tell()
    np.testing.assert_allclose(window.sent[-1], narrow)
    assert len(window.sent) > 1 and not np.array_equal(window.sent[-2], window.sent[-1])


def test_of_a_page_that_is_where_it_is_sent_the_next_move_is_a_person_s():
    window = opened(1.5)
    sent = len(window.sent)
    window.camera.show(_FITTED)  # the same place, written otherwise
    assert len(window.sent) == sent
    window.orbit(1.0, -4.0, 1.0)
    assert len(window.told) == 1


def test_a_shown_place_is_looked_from_and_the_view_goes_back():
    window = opened(1.5)
    fitted = window.position
    window.orbit(1.0, -4.0, 1.0)
    window.camera.show(NO_CAMERA)
    np.testing.assert_array_equal(window.position, fitted)
    window.tell()
    assert len(window.told) == 1


def test_a_window_of_another_shape_keeps_the_view():
    window = opened(1.6, ELSEWHERE)
    window.aspect = 0.9
    window.tell()
    np.testing.assert_allclose(window.position, opened(0.9, ELSEWHERE).position)
    assert window.told == []


def test_a_view_from_very_far_is_told_within_what_a_state_can_hold():
    window = opened(1.5)
    window.orbit(1e6, -1e6, 0.0)
    (place,) = window.told
    assert State(camera=place).camera == place


def test_back_at_the_first_view_a_page_has_no_view_of_its_own():
    window = opened(1.5)
    first = window.position
    window.orbit(*first + np.array([1.0, 0.5, 0.2]))
    window.orbit(*first)
    assert window.told[0] != NO_CAMERA
    assert window.told[1:] == [NO_CAMERA]


@pytest.mark.parametrize("way", [(2.0, 0.0, 1.0), (0.0, 4.0, -3.0), (-3.0, -2.0, 0.1)])
def test_what_lies_to_the_right_of_another_view_is_told_once(way: tuple[float, float, float]):
    window = opened(1.5)
    assert window.turned == []  # the first view has the panes where they are
    window.orbit(*(np.array(way) + window.look_at))
    window.tell()
    (right,) = window.turned
    forward = window.look_at - window.position
    across = np.cross(forward, [0.0, 0.0, 1.0])
    np.testing.assert_allclose(right, across / np.linalg.norm(across), atol=1e-12)


def test_nearly_straight_from_above_the_panes_still_turn_with_the_view():
    window = opened(1.5)
    window.orbit(*(window.look_at + np.array([0.001, 0.001, 5.0])))
    np.testing.assert_allclose(window.turned, [[-np.sqrt(0.5), np.sqrt(0.5), 0.0]], atol=1e-3)


def test_what_a_page_tells_on_its_way_turns_nothing():
    window = Window(1.5)
    window.tell()  # viser's first camera
    window.camera.begin((1.0, 0.0, 0.2, 0.0, 0.0, 0.0))
    assert len(window.turned) == 1
    window.orbit(3.0, 3.0, 3.0)  # told before it got there
    assert len(window.turned) == 1


def test_a_shared_view_is_told_before_the_page_is_there():
    window = Window(1.5)
    window.camera.begin((1.0, 0.0, 0.2, 0.0, 0.0, 0.0))
    np.testing.assert_allclose(window.turned, [[0.0, 1.0, 0.0]], atol=1e-12)
