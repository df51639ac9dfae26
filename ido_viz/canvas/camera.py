"""From where the canvas is seen: both panes whole in any window, until a person looks from elsewhere."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from ido.types import DoubleArray
from ido_viz.core.geometry import VIEW_DIRECTION
from ido_viz.core.state import FARTHEST, NO_CAMERA

_WIDTH = 5.4  # of both panes, model units: the camera steps back until they fit
_HEIGHT = 3.1  # of a pane, with room for what is written above and below it
_PORTRAIT = 0.6  # a canvas narrower than this share of its height is a phone's
_PATIENCE = 20.0  # seconds in which a page gets to the place that it was sent
_LIFT = 0.12  # of the height that is seen
_SETTLING = 0.03  # seconds after which what is read of a camera belongs together
_SAME = 0.01  # places that differ less are one
_SAME_SIDE = 0.002  # and directions to the right
_ASIDE = 0.001  # model units: seen by nobody


class Camera:
    """The camera of one page.

    Its place is told as six numbers that hold in a window of any shape: from what it looks at to the camera, divided by
    the distance from which both panes fit, and what it looks at, from the middle of both panes.

    Args:
        camera: of the page.
        moved: called with these numbers when a person has moved it.
        turned: called with the horizontal direction that points to the right in the window, shape (3,), where another
            one does.
    """

    def __init__(
        self,
        camera: viser.CameraHandle,
        moved: Callable[[tuple[float, ...]], None],
        turned: Callable[[DoubleArray], None],
    ) -> None:
        self._camera = camera
        self._moved = moved
        self._turned = turned
        self._right: DoubleArray = np.array([1.0, 0.0, 0.0])
        self._aspect = 0.0  # of the window that it was placed for
        self._placed: tuple[float, ...] = NO_CAMERA
        self._lifted = False
        self._awaited_until = 0.0  # until the page has the place that was sent, it tells of others on the way
        self._sent = 0.0  # the time of what the camera's handle holds; another one once the page has told of a place
        self._has_news = False  # whether the page has told of a place that nobody was told of yet
        self._telling = threading.Lock()  # held by the callback that does that
        self._lock = threading.Lock()  # the camera's callbacks overtake each other
        camera.on_update(lambda _: self._on_update())

    def begin(self, place: tuple[float, ...]) -> None:
        """Look from a place of the state, if it was not looked from any yet; sent with the first frame, to tell of it.

        Later frames may have been overtaken by a person who moves the camera, so they do not place it.
        """
        with self._lock:
            if not self._aspect:
                self._placed = place
                self._place()

    def lift(self, lifted: bool) -> None:
        """Leave room below the panes, or no longer."""
        with self._lock:
            if lifted != self._lifted:
                self._lifted = lifted
                if self._aspect:
                    self._place()

    def show(self, place: tuple[float, ...]) -> None:
        """Look from a place of the state, unless the page does already."""
        with self._lock:
            if self._aspect and place != self._placed:
                self._placed = place
                self._place()

    def _on_update(self) -> None:
        if self._elsewhere() is None:
            return
        self._has_news = True
        while self._has_news and self._telling.acquire(blocking=False):  # one is enough: the threads are everybody's
            try:
                time.sleep(_SETTLING)  # position and direction come one after the other: either may have been the older
                self._has_news = False
                self._tell()
            finally:
                self._telling.release()

    def _tell(self) -> None:
        place = self._elsewhere()
        if place is not None:
            place = NO_CAMERA if np.allclose(place, _FITTED, atol=_SAME) else place
            with self._lock:
                self._placed = place
            self._moved(place)  # by one thread at a time, or an older place could be told last

    def _elsewhere(self) -> tuple[float, ...] | None:
        """From where a person looks, if it is not the place that was sent."""
        with self._lock:
            if not self._aspect:
                return None
            if abs(self._camera.aspect - self._aspect) > 0.02 * self._camera.aspect:  # another window
                self._place()
                return None
            place = self._seen()
            is_there = np.allclose(place, self._placed or _FITTED, atol=_SAME)
            awaited = time.perf_counter() < self._awaited_until
            if is_there and self._camera.update_timestamp != self._sent:  # the page's word, not the place just sent
                self._awaited_until = 0.0
            if is_there or not awaited:
                self._turn()
        return None if is_there or awaited else place

    def _place(self) -> None:
        self._aspect = self._camera.aspect
        distance, middle = self._fit()
        place = np.array(self._placed or _FITTED)
        look_at = middle + place[3:]
        position = look_at + distance * place[:3]
        awaits = time.perf_counter() < self._awaited_until
        told = np.concatenate([self._camera.position, self._camera.look_at])
        if not awaits and np.allclose(told, np.concatenate([position, look_at]), atol=_ASIDE / 2):
            return  # the page is there, and would not tell of it again
        self._awaited_until = time.perf_counter() + _PATIENCE
        # viser does not send a place that the page has just told of, even if another one is on its way there; so one a
        # little aside goes first
        for aside in (_ASIDE, 0.0):
            self._camera.position = position + aside
            self._camera.look_at = look_at + aside
        self._sent = self._camera.update_timestamp
        self._turn()

    def _turn(self) -> None:
        """Tell of what lies to the right now. A camera has no roll, so that is horizontal, also straight from above."""
        right = Rotation.from_quat(self._camera.wxyz, scalar_first=True).apply([1.0, 0.0, 0.0])
        right[2] = 0.0
        right /= np.linalg.norm(right) or 1.0
        if not np.allclose(right, self._right, atol=_SAME_SIDE):
            self._right = right
            self._turned(right)

    def _seen(self) -> tuple[float, ...]:
        distance, middle = self._fit()
        look_at = np.asarray(self._camera.look_at)
        place = np.concatenate([(np.asarray(self._camera.position) - look_at) / distance, look_at - middle])
        return tuple(np.clip(np.round(place, 3), -FARTHEST, FARTHEST).tolist())

    def _fit(self) -> tuple[float, DoubleArray]:
        """The distance from which both panes fit, and their middle."""
        portrait = self._aspect < _PORTRAIT
        height = max(_HEIGHT, _WIDTH / self._aspect * (1.1 if portrait else 1.0))
        distance = height / 2 / float(np.tan(self._camera.fov / 2))
        # on a phone the controls cover the lower part, so the panes move up
        return distance, np.array([0.0, 0.0, -height * (0.27 if portrait else _LIFT if self._lifted else 0.0)])


_FITTED = (*(VIEW_DIRECTION / np.linalg.norm(VIEW_DIRECTION)).tolist(), 0.0, 0.0, 0.0)
