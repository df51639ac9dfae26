"""Nodes of a pane at a pose: what stays as it is is not sent again, and what is not seen is not sent at all."""

from __future__ import annotations

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from ido.types import FloatArray
from ido_viz.core.geometry import quaternion
from ido_viz.core.palette import GUIDE, Color


class PlacedFrame:
    """A node that others hang on, at a pose."""

    def __init__(self, scene: viser.SceneApi, name: str, *, visible: bool = True) -> None:
        self._frame = scene.add_frame(name, show_axes=False, visible=visible)
        self._T = np.eye(4)

    def place(self, T: FloatArray) -> None:
        """Move it to a pose, shape (4, 4)."""
        if not np.array_equal(T, self._T):
            self._T = T
            self._frame.wxyz = quaternion(Rotation.from_matrix(T[:3, :3]))
            self._frame.position = T[:3, 3]

    def show(self, shown: bool) -> None:
        """Show or hide all that hangs on it."""
        self._frame.visible = shown


class Echo:
    """The scene's points once more, at another pose.

    Args:
        scene: where they are drawn.
        name: of their node.
        size: of the points, model units.
    """

    def __init__(self, scene: viser.SceneApi, name: str, size: float) -> None:
        self._frame = PlacedFrame(scene, name, visible=False)
        self._cloud = scene.add_point_cloud(
            f"{name}/points", np.zeros((1, 3), dtype=np.float32), GUIDE, point_size=size, point_shape="circle"
        )
        self._points: FloatArray | None = None

    def draw(self, points: FloatArray, T: FloatArray, color: Color) -> None:
        """Show points (n, 3) at a pose (4, 4)."""
        if points is not self._points:
            self._points = self._cloud.points = points
        self._cloud.colors = np.array(color)
        self._frame.place(T)
        self._frame.show(True)

    def hide(self) -> None:
        """Show nothing."""
        self._frame.show(False)
