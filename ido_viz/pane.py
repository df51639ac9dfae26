"""One pane of the 3D canvas: the model, the moving scene, where it belongs, and what is looked into."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from ido import Scene, Trajectory, poses
from ido.types import BoolArray, FloatArray
from ido_viz import palette
from ido_viz.diagram import Diagram
from ido_viz.heatmaps import diverging_colors
from ido_viz.microscope import Inspection, answers, asked
from ido_viz.overlay import Overlaid, overlaid
from ido_viz.run import MethodRun, Run
from ido_viz.state import Question, State

PANE_OFFSETS = (-1.5, 1.5)
"""x of each pane's centre, model units."""

_NO_LINES = np.zeros((1, 2, 3), dtype=np.float32)
_NO_POINTS = np.zeros((1, 3), dtype=np.float32)
_FAINT = 0.06  # of the ink, for the points that are not asked about


class PaneView:
    """Draws one side of a run. Moving a scene sends a pose, not points.

    Args:
        scene: where it is drawn.
        side: number of the side, 0 for the left one.
    """

    def __init__(self, scene: viser.SceneApi, side: int) -> None:
        self._side = side
        self._color = palette.METHODS[side]
        root = f"/{('left', 'right')[side]}"
        self._root = scene.add_frame(root, show_axes=False, position=(PANE_OFFSETS[side], 0.0, 0.0))
        self._label = scene.add_label(
            f"{root}-title", "", position=(PANE_OFFSETS[side], 0.0, 1.3), anchor="bottom-center"
        )

        def cloud(name: str, color: palette.Color, size: float) -> Any:
            return scene.add_point_cloud(f"{root}/{name}", _NO_POINTS, color, point_size=size, point_shape="circle")

        def lines(name: str, color: palette.Color, thickness: float) -> Any:
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
        self._drawn: tuple[Scene, Trajectory] | None = None
        self._look: tuple[object, ...] | None = None

    def draw(self, run: Run, state: State, iteration: int, inspection: Inspection | None) -> None:
        """Draw the side after so many iterations, and what is looked into if it is this side."""
        side = run.sides[self._side]
        look = (id(side.histogram.model), state.shape)
        if look != self._look:
            self._root.wxyz = upright(run.subject.up)
            self._model.points = side.histogram.model.points
            self._look = look
        self._paint(run, side, state, inspection)
        if (run.scene, side.trajectory) != self._drawn:
            self._place(run.scene, side)
        self._ghost.visible = state.ghost and (inspection is None or inspection.point is None)
        k = side.clipped(iteration)
        _move(self._scene, side.T_model_scene[k])
        self._connect(run.scene, side.T_model_scene[k], inspection, shown=state.error_vectors)
        over = overlaid(run, state, iteration, self._side)
        self._lay_over(over)
        self._label.font_screen_scale = 1.3 if state.large_text else 1.0
        self._label.text = _title(side, k, over, with_scores="scores" not in state.hidden)

    def _place(self, scene: Scene, side: MethodRun) -> None:
        """Draw what stays where it is while a registration is played."""
        true_points = scene.points[~scene.is_outlier]
        self._points.points = self._overlay_points.points = true_points
        self._outliers.points = scene.points[scene.is_outlier]
        self._outliers.visible = bool(scene.is_outlier.any())
        self._ghost.points = poses.transform(scene.T_model_scene, true_points).astype(np.float32)
        middle = true_points.mean(axis=0)
        track = (poses.transform(side.T_model_scene, middle[None])[:, 0]).astype(np.float32)
        self._trail.points = np.stack([track[:-1], track[1:]], axis=1) if len(track) > 1 else _NO_LINES
        self._drawn = (scene, side.trajectory)

    def _connect(self, scene: Scene, T: FloatArray, inspection: Inspection | None, *, shown: bool) -> None:
        """Draw a line from each scene point that is no outlier to where it belongs, or from the picked one alone."""
        one = None if inspection is None or inspection.point is None else inspection.scene_point
        lines = error_vectors(scene, T, one) if shown else _NO_LINES[:0]
        self._errors.visible = len(lines) > 0
        if len(lines):
            self._errors.points = lines

    def _lay_over(self, over: Overlaid | None) -> None:
        self._overlay.visible = over is not None
        if over is not None:
            _move(self._overlay, over.T_model_scene)
            self._overlay_points.colors = np.array(over.color)

    def _paint(self, run: Run, side: MethodRun, state: State, inspection: Inspection | None) -> None:
        """Colour the model by height or by shares, and the scene by the inspected point's answers."""
        model = side.histogram.model
        point = inspection.point if inspection is not None else None
        one = inspection.scene_point if inspection is not None else None
        partner = inspection.moved[one] if inspection is not None and one is not None else None
        self._diagram.draw(model, point, state.question, partner)
        shares = inspection.of_points if inspection is not None and state.coloring != "height" else None
        plain = (id(model), run.subject.up, state.dark) if shares is None else None
        if plain is None or plain != self._plain:
            height = model.points @ np.array(run.subject.up)
            self._model.colors = _model_colors(height, state.dark) if shares is None else diverging_colors(shares)
            self._plain = plain
        answered = point is not None and asked(side.histogram, state.question)
        if answered:
            assert inspection is not None and point is not None
            first, counts = answers(side.histogram, inspection.moved, point, state.question)
            if one is not None:  # the others stand back
                counts = np.where(np.arange(len(counts)) == one, 1.0, _FAINT)
            colors = answer_colors(first, counts, state.question, state.dark)
            self._points.colors = colors[~run.scene.is_outlier]
            self._outliers.colors = colors[run.scene.is_outlier]
        elif self._answered:
            self._points.colors, self._outliers.colors = np.array(self._color), np.array(palette.OUTLIER)
        self._answered = answered


def error_vectors(scene: Scene, T_model_scene: FloatArray, one: int | None = None) -> np.ndarray:
    """From where each scene point that is no outlier lies at a pose to where it belongs; float32, shape (n, 2, 3).

    Args:
        scene: whose points.
        T_model_scene: the pose, shape (4, 4).
        one: number of a scene point, for its line alone; None for all. An outlier belongs nowhere and has none.
    """
    chosen = ~scene.is_outlier
    if one is not None:
        chosen &= np.arange(len(chosen)) == one
    points = scene.points[chosen]
    return np.stack([poses.transform(T, points) for T in (T_model_scene, scene.T_model_scene)], axis=1).astype(
        np.float32
    )


def answer_colors(first: BoolArray, counts: FloatArray, question: Question, dark: bool) -> np.ndarray:
    """The block's colour for points on its first side, ink for the others, paler where they count less; (S, 3)."""
    color = palette.BLOCKS[get_args(Question).index(question)]
    full = np.where(first[:, None], np.array(color), np.array(palette.ink(dark)))
    faint = np.array((45, 45, 45) if dark else (228, 228, 228))
    return np.rint(faint + (full - faint) * counts[:, None]).astype(np.uint8)


def upright(up: tuple[float, float, float]) -> FloatArray:
    """Quaternion (w, x, y, z) that turns a shape's up direction to +z."""
    rotation = Rotation.align_vectors(np.array([[0.0, 0.0, 1.0]]), np.array([up]))[0]
    return rotation.as_quat(scalar_first=True)


def _move(frame: viser.FrameHandle, T: FloatArray) -> None:
    frame.wxyz = Rotation.from_matrix(T[:3, :3]).as_quat(scalar_first=True)
    frame.position = T[:3, 3]


def _title(side: MethodRun, k: int, over: Overlaid | None, *, with_scores: bool) -> str:
    lines = [side.method, side.waiting or f"iteration {k} of {side.trajectory.iterations}"]
    if with_scores:
        lines += [f"PointRMSE {side.scores.rmse[k]:.3f}", f"PointAcc {side.scores.accuracy[k]:.2f}"]
    if over is not None:
        lines.append(f"with {over.title}")
    return "\n".join(lines)


def _model_colors(height: FloatArray, dark: bool) -> np.ndarray:
    """Greys by height, so that the shape can be read; shape (M, 3)."""
    share = (height - height.min()) / max(float(np.ptp(height)), 1e-9)
    low, high = (110, 235) if dark else (90, 185)
    return np.repeat((low + (high - low) * share)[:, None], 3, axis=1).astype(np.uint8)
