"""What a step points at in the 3D view: arrows with a word at their tail."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import viser

from ido.poses import transform
from ido.types import DoubleArray
from ido_viz.canvas.ball import add_ball
from ido_viz.core import palette
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.geometry import upright
from ido_viz.core.palette import Color
from ido_viz.core.state import Pane

Mark = Literal["model point", "scene point", "answer", "outliers", "scene", "up", "round"]

_AWAY = {
    "model point": (-0.3, 0.0, -0.7),
    "scene point": (0.55, 0.0, 0.5),
    "answer": (0.55, 0.0, 0.5),
    "outliers": (0.3, 0.0, 0.5),
    "scene": (0.25, 0.0, 0.95),
}
"""From what is pointed at to the word, as it is seen from the front, model units."""

_GAP = 0.04  # from the arrow's head to what it points at, or to its ball
_HIGH = 0.5  # above it, a word is below what it points at, clear of the pane's title; model units
_WIDE = 0.75  # further from the middle of its pane, a word would reach into the other pane; model units
_REACH = 1.1  # of the axis, below the title of a pane
_AXIS_LABELS = {"up": "up: the z axis", "round": "further round"}
_BALLS = {"model point": 0.06, "scene point": 0.05, "answer": 0.05}
"""Radii of the balls that what is picked is drawn as, larger than where nothing is said of it; model units."""


@dataclass(frozen=True, slots=True, eq=False)
class Pointer:
    """An arrow in a pane.

    Args:
        pane: number of the pane, 0 for the left one.
        label: the word.
        path: points from the word to the head, or of an axis to the word at its head, in the model's frame; shape
            (n, 3), n at least 2.
        ball: radius of the ball at what is pointed at, model units; 0 for none.
        tip: what is pointed at, in the model's frame, shape (3,); of an axis, its end.
        color: of the ball.
    """

    pane: int
    label: str
    path: DoubleArray
    tip: DoubleArray
    ball: float
    color: Color


def pointers(frame: Frame, marks: tuple[Mark, ...]) -> tuple[Pointer, ...]:
    """The arrows of some marks; a point that is not there has none."""
    found = []
    for mark in marks:
        for side in frame.sides if mark in ("outliers", "scene") else (frame.inspected,):
            tip = _tip(frame, side, mark)
            if tip is None:
                continue
            path = _path(frame, tip, mark)
            color = palette.MARK if mark == "model point" else palette.method_color(side.run.method, frame.state.dark)
            found.append(Pointer(side.pane, _word(frame, side, mark), path, tip, _BALLS.get(mark, 0.0), color))
    return tuple(found)


def _word(frame: Frame, side: SideFrame, mark: Mark) -> str:
    if mark == "outliers" and int(frame.run.scene.is_outlier.sum()) == 1:
        return "outlier"
    inspection = side.inspection
    if mark == "answer" and inspection is not None and inspection.answers is not None:
        first, counts = inspection.answers
        question, one = inspection.question, inspection.scene_point
        assert question is not None and one is not None
        return f"scene point\n{question.first if first[one] else question.second}, weight {counts[one]:.2f}"
    return _AXIS_LABELS.get(mark, mark)


def _path(frame: Frame, tip: DoubleArray, mark: Mark) -> DoubleArray:
    if mark == "up":
        return np.stack([np.zeros(3), tip])
    if mark == "round":
        return _arc()
    turn, away = upright(frame.run.subject.up), np.array(_AWAY[mark])
    seen = turn.apply(tip)
    if mark != "scene" and seen[2] > _HIGH:
        away[2] = -abs(away[2])
    if abs(seen[0] + away[0]) > _WIDE:
        away[0] = -np.copysign(away[0], seen[0])
    away = turn.inv().apply(away)
    return np.stack([tip + away, tip + (_GAP + _BALLS.get(mark, 0.0)) * away / np.linalg.norm(away)])


def _arc() -> DoubleArray:
    """Part of a circle around the z axis, the way that angles grow; shape (n, 3)."""
    angle = np.linspace(-0.4, 1.1, 16)
    return np.stack([np.cos(angle), np.sin(angle), np.zeros(16)], axis=1)


def _tip(frame: Frame, side: SideFrame, mark: Mark) -> DoubleArray | None:
    """What a mark points at, in the model's frame; None for what is not there."""
    if mark == "up":
        return np.array([0.0, 0.0, _REACH])
    if mark == "round":
        return _arc()[-1]
    if mark in ("outliers", "scene"):
        scene = frame.run.scene
        points = scene.points[scene.is_outlier == (mark == "outliers")]
        return transform(side.T_model_scene, points.mean(axis=0, dtype=np.float64)[None])[0] if len(points) else None
    inspection = side.inspection
    if inspection is None or inspection.point is None:
        return None
    if mark == "model point":
        return side.run.histogram.model.points[inspection.point].astype(np.float64)
    return None if inspection.scene_point is None else inspection.moved[inspection.scene_point].astype(np.float64)


class Marks:
    """Draws the arrows of a step."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._shown: tuple[object, ...] = ()
        self._names: list[str] = []

    def draw(self, found: tuple[Pointer, ...], *, dark: bool, large: bool) -> None:
        """Draw these arrows in place of those before."""
        look = (dark, large, *((each.pane, each.label, each.path.tobytes()) for each in found))
        if look == self._shown:
            return
        self._shown = look
        for name in self._names:
            self._scene.remove_by_name(name)
        self._names = [f"/{get_args(Pane)[each.pane]}/mark-{number}" for number, each in enumerate(found)]
        color = palette.ink(dark)
        for name, each in zip(self._names, found, strict=True):
            path = each.path.astype(np.float32)
            self._scene.add_frame(name, show_axes=False)
            if each.ball:
                add_ball(self._scene, f"{name}/ball", each.tip, each.ball, each.color)
            self._scene.add_line_segments(
                f"{name}/shaft",
                np.stack([path[:-1], path[1:]], axis=1),
                np.array(color),
                thickness=3.0,
                thickness_units="screen",
            )
            head = path[-1] + 0.1 * (path[-2] - path[-1]) / np.linalg.norm(path[-2] - path[-1])
            self._scene.add_arrows(
                f"{name}/head", np.array([[head, path[-1]]]), color, shaft_radius=0.01, head_radius=0.035
            )
            at_head = each.label in _AXIS_LABELS.values()
            self._scene.add_label(
                f"{name}/word",
                each.label,
                position=path[-1 if at_head else 0],
                anchor="bottom-center",
                font_screen_scale=1.4 if large else 1.1,
            )
