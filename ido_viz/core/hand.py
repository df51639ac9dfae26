"""A scene in somebody's hand: how the handles' motion becomes the scene's start pose."""

from __future__ import annotations

import numpy as np

from ido import poses
from ido.types import FloatArray
from ido_viz.core.frame import Frame
from ido_viz.core.state import FARTHEST


class Hand:
    """Holds a scene from the start of a gesture to its end."""

    def __init__(self) -> None:
        self._grip: FloatArray | None = None  # T_handles^-1 T_start

    def start_pose(self, drawn: Frame, pane: int, phase: str, T_handles: FloatArray) -> tuple[float, ...] | None:
        """The state's start pose when the handles are somewhere.

        None for a gesture whose start was missed, and where the handles are farther away than a state can hold.

        Args:
            drawn: what the page shows: at the start of a gesture the scene is taken from where it lies there.
            pane: whose handles they are.
            phase: of the gesture: start, update or end.
            T_handles: where they are in the model's frame, shape (4, 4).
        """
        if phase == "start":
            before = poses.exp(np.array(drawn.state.start or np.zeros(6)))
            self._grip = poses.invert(T_handles) @ drawn.sides[pane].T_model_scene @ before
        if self._grip is None:
            return None
        start = np.round(poses.log(T_handles @ self._grip), 4)
        if phase == "end":
            self._grip = None
        return tuple(start.tolist()) if np.abs(start).max() <= FARTHEST else None
