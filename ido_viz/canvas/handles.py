"""Handles in 3D, by which a person takes hold of the scene, turns and shifts it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from ido import Scene, poses
from ido.types import FloatArray
from ido_viz.core.geometry import quaternion

_SIZE = 0.62  # model units


class Handles:
    """The handles of one pane, around the middle of its scene.

    Args:
        scene: where they are drawn.
        root: the pane's node; they move in its frame.
        grabbed: called with the phase of a gesture (start, update, end) and the pose of the handles, shape (4, 4).
    """

    def __init__(self, scene: viser.SceneApi, root: str, grabbed: Callable[[str, FloatArray], None]) -> None:
        self._controls = scene.add_transform_controls(
            f"{root}/handles", scale=_SIZE, line_width=3.5, disable_sliders=True, depth_test=False, opacity=0.7
        )
        self._held = self._turned = False
        self._grabbed = grabbed
        self._controls.on_update(self._on_update)

    async def _on_update(self, event: Any) -> None:  # in the order of the gesture; threads would overtake each other
        self._held, self._turned = event.phase != "end", True
        self._grabbed(event.phase, self._pose())

    def draw(self, scene: Scene, T_model_scene: FloatArray, *, shown: bool) -> None:
        """Place them at the middle of the scene at a pose, unless they are in somebody's hand."""
        if self._controls.visible != shown:
            self._controls.visible = shown
        if self._held or not shown:
            return
        middle = poses.transform(T_model_scene, scene.points[~scene.is_outlier].mean(axis=0)[None])[0]
        self._controls.position = middle
        if self._turned:
            self._controls.wxyz = quaternion(Rotation.identity())
            self._turned = False

    def _pose(self) -> FloatArray:
        T = np.eye(4)
        T[:3, :3] = Rotation.from_quat(self._controls.wxyz, scalar_first=True).as_matrix()
        T[:3, 3] = self._controls.position
        return T
