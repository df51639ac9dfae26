"""The 3D canvas: two panes in one scene, each with the model, the moving scene and where it belongs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import get_args

import numpy as np
import viser

from ido.types import FloatArray
from ido_viz.canvas.pane import PANE_OFFSETS, PaneView
from ido_viz.core.frame import Frame
from ido_viz.core.geometry import VIEW_DIRECTION, point_on_ray, upright
from ido_viz.core.run import Run
from ido_viz.core.state import Pane

_SHOWN_WIDTH = 6.0  # of both panes, and their height: the camera steps back until they fit
_SHOWN_HEIGHT = 3.6
_CLICK_REACH = 0.04  # of a click's ray from a model point, model units
_PORTRAIT = 0.6  # a canvas narrower than this share of its height is a phone's


class Canvas:
    """Draws both panes of one page. Moving a scene sends a pose, not points.

    Args:
        client: the page.
        clicked: called with origin and direction of the ray of a click.
    """

    def __init__(self, client: viser.ClientHandle, clicked: Callable[[FloatArray, FloatArray], None]) -> None:
        scene = client.scene
        scene.on_click()(lambda event: clicked(np.array(event.ray_origin), np.array(event.ray_direction)))
        scene.set_up_direction("+z")
        self._panes = [PaneView(scene, pane) for pane in range(2)]
        self._camera = client.camera
        self._fitted_aspect = 0.0
        self._fitting = threading.Lock()  # the camera's callbacks overtake each other
        self._camera.on_update(lambda _: self._fit_camera())
        self._fit_camera()

    def _fit_camera(self) -> None:
        """Step back so that both panes fit, when the window has been given another shape."""
        with self._fitting:
            aspect = self._camera.aspect
            if abs(aspect - self._fitted_aspect) < 0.02 * aspect:
                return
            self._fitted_aspect = aspect
            height = max(_SHOWN_HEIGHT, _SHOWN_WIDTH / aspect * (1.0 if aspect > _PORTRAIT else 1.15))
            distance = height / 2 / np.tan(self._camera.fov / 2)
            # on a phone the controls cover the lower part, so the panes move up
            target = np.array([0.0, 0.0, 0.1 if aspect > _PORTRAIT else -0.27 * height])
            self._camera.position = target + distance * VIEW_DIRECTION / np.linalg.norm(VIEW_DIRECTION)
            self._camera.look_at = target

    def draw(self, frame: Frame) -> None:
        """Draw both panes."""
        for pane in self._panes:
            pane.draw(frame)


def point_at(run: Run, origin: FloatArray, direction: FloatArray) -> tuple[Pane, int] | None:
    """The pane and number of the model point that a ray in the 3D view meets."""
    turn = upright(run.subject.up)
    for pane, x, side in zip(get_args(Pane), PANE_OFFSETS, run.sides, strict=True):
        points = turn.apply(side.histogram.model.points) + np.array([x, 0.0, 0.0])
        found = point_on_ray(points, origin, direction, _CLICK_REACH)
        if found is not None:
            return pane, found
    return None
