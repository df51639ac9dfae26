"""One pane of the 3D canvas: the model, the moving scene, where it belongs, and what is looked into."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from ido import Question, Scene, poses
from ido.types import BoolArray, DoubleArray, FloatArray
from ido_viz.canvas.diagram import Diagram
from ido_viz.canvas.handles import Handles
from ido_viz.canvas.model_view import ModelView
from ido_viz.canvas.placed import Echo, PlacedFrame
from ido_viz.canvas.race_view import RaceView
from ido_viz.core import palette
from ido_viz.core.caption import Caption
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.geometry import error_vectors, quaternion, track_of, upright
from ido_viz.core.inside import Inside
from ido_viz.core.inspection import Inspection
from ido_viz.core.palette import Color
from ido_viz.core.run import MethodRun
from ido_viz.core.state import BEATS, NO_POINT

PANE_OFFSETS = (-1.17, 1.17)
"""Of each pane's centre, to the right of the middle between them, model units."""

_NO_LINES = np.zeros((1, 2, 3), dtype=np.float32)
_NO_POINTS = np.zeros((1, 3), dtype=np.float32)
_HOLLOW = (  # an octahedron, drawn by its edges: every other face has them all, once each
    0.018 * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float32),
    np.array([[0, 2, 4], [1, 3, 4], [1, 2, 5], [0, 3, 5]], dtype=np.uint32),
)
_FAINT = 0.06  # of the ink, for the points that are not asked about


class PaneView:
    """Draws one side of a frame. Moving a scene sends a pose, not points.

    Args:
        scene: where it is drawn.
        pane: its number, 0 for the left one.
        grabbed: called when the scene is taken hold of and moved: with the phase of the gesture (start, update, end)
            and where the handles are in the model's frame, shape (4, 4). Without it there are no handles.
        titled: whether what stands beside the canvas on a page is written into the picture.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        pane: int,
        grabbed: Callable[[str, FloatArray], None] | None = None,
        *,
        titled: bool = False,
    ) -> None:
        self._pane = pane
        root = f"/{('left', 'right')[pane]}"
        self.place: DoubleArray = np.array([PANE_OFFSETS[pane], 0.0, 0.0])
        """Where its centre is in the 3D view, shape (3,)."""
        self._root = scene.add_frame(root, show_axes=False, position=self.place)
        self._label: Any = None
        if titled:
            place = (PANE_OFFSETS[pane], 0.0, 1.3)
            self._label = scene.add_label(f"{root}-title", "", position=place, anchor="bottom-center")

        def cloud(name: str, color: Color, size: float) -> Any:
            return scene.add_point_cloud(f"{root}/{name}", _NO_POINTS, color, point_size=size, point_shape="circle")

        def lines(name: str, color: Color, thickness: float) -> Any:
            return scene.add_line_segments(
                f"{root}/{name}", _NO_LINES, np.array(color), thickness=thickness, thickness_units="screen"
            )

        self._model = ModelView(scene, root)
        self._ghost = scene.add_batched_meshes_simple(
            f"{root}/ghost",
            *_HOLLOW,
            batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
            batched_positions=_NO_POINTS,
            batched_colors=palette.GHOST,
            wireframe=True,
            cast_shadow=False,
            receive_shadow=False,
        )
        self._trail = lines("trail", palette.GUIDE, 2.0)
        self._errors = lines("errors", palette.GHOST, 1.0)
        self._arrow = lines("arrow", palette.GUIDE, 4.0)
        self._arc = lines("arc", palette.GUIDE, 2.5)
        self._scene = PlacedFrame(scene, f"{root}/scene")
        self._points = cloud("scene/points", palette.GUIDE, 0.032)
        self._outliers = cloud("scene/outliers", palette.OUTLIER, 0.012)
        self._end = Echo(scene, f"{root}/end", 0.018)
        self._overlay = Echo(scene, f"{root}/overlay", 0.02)
        self._handles = None if grabbed is None else Handles(scene, root, grabbed)
        self._diagram = Diagram(scene, root)
        self._race = RaceView(scene, root)
        self._true_points: FloatArray = _NO_POINTS
        self._colors: np.ndarray | None = None
        self._drawn: tuple[object, ...] | None = None
        self._up: tuple[float, ...] | None = None

    def show(self, shown: bool) -> None:
        """Show all of the pane, or nothing."""
        self._root.visible = shown

    def stand(self, place: DoubleArray) -> None:
        """Put its centre at a place of the 3D view, shape (3,)."""
        self.place = place
        self._root.position = place

    def draw(self, frame: Frame) -> None:
        """Draw the pane's side of a frame, and what is looked into; of the other side, the picked points alone."""
        run, state, side = frame.run, frame.state, frame.sides[self._pane]
        inside = frame.inside if side is frame.inspected else None
        inspection = side.inspection if side is frame.inspected and (inside is None or inside.asks) else None
        if run.subject.up != self._up:
            self._root.wxyz = quaternion(upright(run.subject.up))
            self._up = run.subject.up
        self._model.draw(frame, self._pane, inspection)
        if (run.scene, side.run.trajectory, side.run.method, state.dark) != self._drawn:
            self._place(run.scene, side.run, state.dark)
        self._paint_scene(frame, side, inspection, inside)
        self._show_motion(inside, frame.state.dark)
        self._ghost.visible = state.ghost and (inspection is None or inspection.point is None)
        self.move(side)
        if frame.held:
            end_color = palette.lighter(palette.method_color(side.run.method, state.dark), state.dark, 0.4)
            self._end.draw(self._true_points, side.run.T_model_scene[-1], end_color)
        else:
            self._end.hide()
        self._connect(run.scene, side.T_model_scene, inspection, shown=state.error_vectors)
        if side.overlay is None:
            self._overlay.hide()
        else:
            self._overlay.draw(self._true_points, side.overlay.T_model_scene, side.overlay.color)
        self._race.draw(run.scene, side, run.subject.up, state.dark)
        if self._handles is not None:
            self._handles.draw(
                run.scene, side.T_model_scene, shown=state.handles and frame.inside is None
            )  # or they hide the point that is asked
        if self._label is not None:
            self._label.font_screen_scale = 1.3 if state.large_text else 1.0
            self._label.text = _title(side.caption)

    def move(self, side: SideFrame) -> None:
        """Move the scene to the pose of a side, and nothing else."""
        self._scene.place(side.T_model_scene)

    def _place(self, scene: Scene, run: MethodRun, dark: bool) -> None:
        """Draw what stays where it is while a registration is played."""
        self._true_points = true_points = scene.points[~scene.is_outlier]
        color = palette.method_color(run.method, dark)
        self._colors = None
        self._points.points = true_points
        self._outliers.visible = bool(scene.is_outlier.any())
        if self._outliers.visible:  # a cloud of no points is none to the browser
            self._outliers.points = scene.points[scene.is_outlier]
        belongs = poses.transform(scene.T_model_scene, true_points).astype(np.float32)
        self._ghost.batched_wxyzs = np.tile([1.0, 0.0, 0.0, 0.0], (len(belongs), 1))
        self._ghost.batched_positions = belongs
        track = track_of(scene, run.T_model_scene)
        self._trail.points = track if len(track) else _NO_LINES
        self._trail.colors = np.array(color)
        self._drawn = (scene, run.trajectory, run.method, dark)

    def _connect(self, scene: Scene, T: FloatArray, inspection: Inspection | None, *, shown: bool) -> None:
        """Draw a line from each scene point that is no outlier to where it belongs, or from the picked one alone."""
        one = None if inspection is None or inspection.point is None else inspection.scene_point
        lines = error_vectors(scene, T, one) if shown else _NO_LINES[:0]
        self._errors.visible = len(lines) > 0
        if len(lines):
            self._errors.points = lines

    def _show_motion(self, inside: Inside | None, dark: bool) -> None:
        """Draw the step that the last beat of the slow motion is about."""
        shown = inside is not None and inside.beat == BEATS
        for lines in (self._arrow, self._arc):
            lines.visible = shown
        if inside is not None and shown:
            arrow, arc = inside.motion
            self._arrow.points, self._arc.points = arrow.astype(np.float32), arc.astype(np.float32)
            self._arrow.colors = self._arc.colors = np.array(palette.ink(dark))

    def _paint_scene(self, frame: Frame, side: SideFrame, inspection: Inspection | None, inside: Inside | None) -> None:
        """Colour the scene by what has arrived, or by the inspected point's answers, with the surface between them."""
        point = one = partner = question = None
        color, dark, is_outlier = palette.GUIDE, frame.state.dark, frame.run.scene.is_outlier
        if inside is not None and inside.asks:
            point, question = inside.point, inside.question
            color = question_color(side.run, question)
        elif inspection is not None:
            point, one, question = inspection.point, inspection.scene_point, inspection.question
            partner = None if one is None else inspection.moved[one]
            color = color if question is None else question_color(side.run, question)
        elif side.marked != NO_POINT:
            point, other = frame.picked, frame.picked_scene_point
            if other is not None:
                (partner,) = poses.transform(side.T_model_scene, frame.run.scene.points[[other]])
        up = None if inside is None else np.array(frame.run.subject.up)
        self._diagram.draw(side.run.histogram.model, point, question, color, partner, named_above=up)
        answers = None if inspection is None else inspection.answers
        if inside is not None and inside.asks:
            answers = inside.asked
        if answers is not None:
            first, counts = answers
            if one is not None:  # the others stand back
                counts = np.where(np.arange(len(counts)) == one, 1.0, _FAINT)
            colors = answer_colors(first, counts, color, dark)
        else:
            colors = np.where(is_outlier[:, None], palette.OUTLIER, palette.method_color(side.run.method, dark))
            if "scores" not in frame.state.hidden:
                colors[~is_outlier] = np.where(side.arrived[:, None], palette.ARRIVED, colors[~is_outlier])
        if self._colors is None or not np.array_equal(colors, self._colors):
            self._points.colors = colors[~is_outlier].astype(np.uint8)
            if is_outlier.any():
                self._outliers.colors = colors[is_outlier].astype(np.uint8)
            self._colors = colors


def question_color(run: MethodRun, question: Question) -> Color:
    """What a block of a method's histogram is drawn in."""
    return palette.block_color(question, run.histogram.blocks.index(question))


def answer_colors(first: BoolArray, counts: FloatArray, color: Color, dark: bool) -> np.ndarray:
    """A block's colour for points on its first side, ink for the others, paler where they count less; (S, 3)."""
    full = np.where(first[:, None], np.array(color), np.array(palette.ink(dark)))
    faint = np.array((45, 45, 45) if dark else (228, 228, 228))
    return np.rint(faint + (full - faint) * counts[:, None]).astype(np.uint8)


def _title(caption: Caption) -> str:
    return "\n".join(filter(None, (caption.method, caption.progress, *caption.scores, caption.overlay)))
