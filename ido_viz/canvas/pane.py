"""One pane of the 3D canvas: the model, the moving scene, where it belongs, and what is looked into."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from ido import Model, Question, Scene, poses
from ido.types import BoolArray, FloatArray
from ido_viz.canvas.diagram import Diagram
from ido_viz.core import palette
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.geometry import error_vectors, quaternion, track_of, upright
from ido_viz.core.inspection import Inspection
from ido_viz.core.overlay import Overlay
from ido_viz.core.palette import Color
from ido_viz.core.run import MethodRun
from ido_viz.core.wording import progress_line

PANE_OFFSETS = (-1.5, 1.5)
"""x of each pane's centre, model units."""

_NO_LINES = np.zeros((1, 2, 3), dtype=np.float32)
_NO_POINTS = np.zeros((1, 3), dtype=np.float32)
_FAINT = 0.06  # of the ink, for the points that are not asked about


class PaneView:
    """Draws one side of a frame. Moving a scene sends a pose, not points.

    Args:
        scene: where it is drawn.
        pane: its number, 0 for the left one.
    """

    def __init__(self, scene: viser.SceneApi, pane: int) -> None:
        self._pane = pane
        self._color = palette.METHOD_COLORS[pane]
        root = f"/{('left', 'right')[pane]}"
        self._root = scene.add_frame(root, show_axes=False, position=(PANE_OFFSETS[pane], 0.0, 0.0))
        self._label = scene.add_label(
            f"{root}-title", "", position=(PANE_OFFSETS[pane], 0.0, 1.3), anchor="bottom-center"
        )

        def cloud(name: str, color: Color, size: float) -> Any:
            return scene.add_point_cloud(f"{root}/{name}", _NO_POINTS, color, point_size=size, point_shape="circle")

        def lines(name: str, color: Color, thickness: float) -> Any:
            return scene.add_line_segments(
                f"{root}/{name}", _NO_LINES, np.array(color), thickness=thickness, thickness_units="screen"
            )

        self._model = cloud("model", (0, 0, 0), 0.022)
        self._ghost = cloud("ghost", palette.GHOST, 0.02)
        self._trail = lines("trail", self._color, 2.0)
        self._errors = lines("errors", palette.GHOST, 1.0)
        self._scene = scene.add_frame(f"{root}/scene", show_axes=False)
        self._points = cloud("scene/points", self._color, 0.03)
        self._outliers = cloud("scene/outliers", palette.OUTLIER, 0.014)
        self._overlay = scene.add_frame(f"{root}/overlay", show_axes=False, visible=False)
        self._overlay_points = cloud("overlay/points", self._color, 0.02)
        self._diagram = Diagram(scene, root)
        self._plain: tuple[object, ...] | None = None
        self._answered = False
        self._drawn: tuple[object, ...] | None = None
        self._look: tuple[object, ...] | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the pane's side of a frame, and what is looked into if it is this side."""
        run, state, side = frame.run, frame.state, frame.sides[self._pane]
        model, inspection = side.run.histogram.model, side.inspection if side is frame.inspected else None
        if (model, run.subject) != self._look:
            self._root.wxyz = quaternion(upright(run.subject.up))
            self._model.points = model.points
            self._look = (model, run.subject)
        self._paint_model(frame, model, inspection)
        self._paint_scene(frame, side, inspection)
        if (run.scene, side.run.trajectory) != self._drawn:
            self._place(run.scene, side.run)
        self._ghost.visible = state.ghost and (inspection is None or inspection.point is None)
        _move(self._scene, side.T_model_scene)
        self._connect(run.scene, side.T_model_scene, inspection, shown=state.error_vectors)
        self._lay_over(side.overlay)
        self._label.font_screen_scale = 1.3 if state.large_text else 1.0
        self._label.text = _title(side, with_scores="scores" not in state.hidden)

    def _place(self, scene: Scene, run: MethodRun) -> None:
        """Draw what stays where it is while a registration is played."""
        true_points = scene.points[~scene.is_outlier]
        self._points.points = self._overlay_points.points = true_points
        self._outliers.points = scene.points[scene.is_outlier]
        self._outliers.visible = bool(scene.is_outlier.any())
        self._ghost.points = poses.transform(scene.T_model_scene, true_points).astype(np.float32)
        track = track_of(scene, run.T_model_scene)
        self._trail.points = track if len(track) else _NO_LINES
        self._drawn = (scene, run.trajectory)

    def _connect(self, scene: Scene, T: FloatArray, inspection: Inspection | None, *, shown: bool) -> None:
        """Draw a line from each scene point that is no outlier to where it belongs, or from the picked one alone."""
        one = None if inspection is None or inspection.point is None else inspection.scene_point
        lines = error_vectors(scene, T, one) if shown else _NO_LINES[:0]
        self._errors.visible = len(lines) > 0
        if len(lines):
            self._errors.points = lines

    def _lay_over(self, over: Overlay | None) -> None:
        self._overlay.visible = over is not None
        if over is not None:
            _move(self._overlay, over.T_model_scene)
            self._overlay_points.colors = np.array(over.color)

    def _paint_model(self, frame: Frame, model: Model, inspection: Inspection | None) -> None:
        """Colour the model by height or by shares."""
        state, up = frame.state, frame.run.subject.up
        shares = inspection.of_points if inspection is not None and state.coloring != "height" else None
        plain = (model, up, state.dark) if shares is None else None
        if plain is not None and plain == self._plain:
            return
        height = model.points @ np.array(up)
        self._model.colors = _greys(height, state.dark) if shares is None else palette.diverging_colors(shares)
        self._plain = plain

    def _paint_scene(self, frame: Frame, side: SideFrame, inspection: Inspection | None) -> None:
        """Colour the scene by the inspected point's answers, and draw the surface where they change."""
        point = one = partner = question = None
        color = palette.GUIDE
        if inspection is not None:
            point, one, question = inspection.point, inspection.scene_point, inspection.question
            partner = None if one is None else inspection.moved[one]
            color = color if question is None else question_color(side.run, question)
        self._diagram.draw(side.run.histogram.model, point, question, color, partner)
        answers = None if inspection is None else inspection.answers
        if answers is not None:
            first, counts = answers
            if one is not None:  # the others stand back
                counts = np.where(np.arange(len(counts)) == one, 1.0, _FAINT)
            colors = answer_colors(first, counts, color, frame.state.dark)
            self._points.colors = colors[~frame.run.scene.is_outlier]
            self._outliers.colors = colors[frame.run.scene.is_outlier]
        elif self._answered:
            self._points.colors, self._outliers.colors = np.array(self._color), np.array(palette.OUTLIER)
        self._answered = answers is not None


def question_color(run: MethodRun, question: Question) -> Color:
    """What a block of a method's histogram is drawn in."""
    return palette.block_color(question, run.histogram.blocks.index(question))


def answer_colors(first: BoolArray, counts: FloatArray, color: Color, dark: bool) -> np.ndarray:
    """A block's colour for points on its first side, ink for the others, paler where they count less; (S, 3)."""
    full = np.where(first[:, None], np.array(color), np.array(palette.ink(dark)))
    faint = np.array((45, 45, 45) if dark else (228, 228, 228))
    return np.rint(faint + (full - faint) * counts[:, None]).astype(np.uint8)


def _move(frame: viser.FrameHandle, T: FloatArray) -> None:
    frame.wxyz = quaternion(Rotation.from_matrix(T[:3, :3]))
    frame.position = T[:3, 3]


def _title(side: SideFrame, *, with_scores: bool) -> str:
    lines = [side.run.method, progress_line(side)]
    if with_scores:
        lines += [f"PointRMSE {side.rmse:.3f}", f"PointAcc {side.accuracy:.2f}"]
    if side.overlay is not None:
        lines.append(f"with {side.overlay.title}")
    return "\n".join(lines)


def _greys(height: FloatArray, dark: bool) -> np.ndarray:
    """Greys by height, so that the shape can be read; shape (M, 3)."""
    share = (height - height.min()) / max(float(np.ptp(height)), 1e-9)
    low, high = palette.model_greys(dark)
    return np.repeat((low + (high - low) * share)[:, None], 3, axis=1).astype(np.uint8)
