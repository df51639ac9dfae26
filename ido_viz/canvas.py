"""The 3D canvas: two panes in one scene, each with the model, the moving scene and where it belongs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import get_args

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from ido import Scene, Trajectory, poses
from ido.types import BoolArray, FloatArray
from ido_viz import palette
from ido_viz.diagram import Diagram
from ido_viz.heatmaps import diverging_colors
from ido_viz.microscope import Inspection, answers, asked, point_on_ray
from ido_viz.run import MethodRun, Run
from ido_viz.state import Pane, Question, State

_PANE_OFFSET = 1.5  # of each pane's centre from the middle, model units
_SHOWN_WIDTH = 6.0  # of both panes, and their height: the camera steps back until they fit
_SHOWN_HEIGHT = 3.6
_CLICK_REACH = 0.04  # of a click's ray from a model point, model units
_PORTRAIT = 0.6  # a canvas narrower than this share of its height is a phone's
_NO_TRAIL = np.zeros((1, 2, 3), dtype=np.float32)
_VIEW_DIRECTION = np.array([0.0, -1.0, 0.35])


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
        self._panes = [_Pane(scene, side) for side in range(2)]
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
            self._camera.position = target + distance * _VIEW_DIRECTION / np.linalg.norm(_VIEW_DIRECTION)
            self._camera.look_at = target

    def draw(self, run: Run, state: State, iteration: int, inspection: Inspection | None) -> None:
        """Draw both panes after so many iterations, and what is looked into."""
        for number, (pane, side) in enumerate(zip(self._panes, run.sides, strict=True)):
            here = inspection if inspection is not None and inspection.pane == number else None
            pane.draw(run, side, state, iteration, here)


class _Pane:
    def __init__(self, scene: viser.SceneApi, side: int) -> None:
        self._color = palette.METHODS[side]
        root = f"/{('left', 'right')[side]}"
        x = (-_PANE_OFFSET, _PANE_OFFSET)[side]
        nothing = np.zeros((1, 3), dtype=np.float32)
        self._root = scene.add_frame(root, show_axes=False, position=(x, 0.0, 0.0))
        self._label = scene.add_label(f"{root}-title", "", position=(x, 0.0, 1.3), anchor="bottom-center")
        self._model = scene.add_point_cloud(f"{root}/model", nothing, (0, 0, 0), point_size=0.022, point_shape="circle")
        self._ghost = scene.add_point_cloud(
            f"{root}/ghost", nothing, palette.GHOST, point_size=0.02, point_shape="circle"
        )
        self._trail = scene.add_line_segments(
            f"{root}/trail", _NO_TRAIL, np.array(self._color), thickness=2.0, thickness_units="screen"
        )
        self._scene = scene.add_frame(f"{root}/scene", show_axes=False)
        self._points = scene.add_point_cloud(
            f"{root}/scene/points", nothing, self._color, point_size=0.03, point_shape="circle"
        )
        self._outliers = scene.add_point_cloud(
            f"{root}/scene/outliers", nothing, palette.OUTLIER, point_size=0.014, point_shape="circle"
        )
        self._diagram = Diagram(scene, root)
        self._plain: tuple[object, ...] | None = None
        self._answered = False
        self._drawn: tuple[Scene, Trajectory] | None = None
        self._look: tuple[object, ...] | None = None

    def draw(self, run: Run, side: MethodRun, state: State, iteration: int, inspection: Inspection | None) -> None:
        look = (id(side.histogram.model), state.shape)
        if look != self._look:
            self._root.wxyz = _upright(run.subject.up)
            self._model.points = side.histogram.model.points
            self._look = look
        self._paint(run, side, state, inspection)
        if (run.scene, side.trajectory) != self._drawn:
            scene = run.scene
            true_points = scene.points[~scene.is_outlier]
            self._points.points = true_points
            self._outliers.points = scene.points[scene.is_outlier]
            self._outliers.visible = bool(scene.is_outlier.any())
            self._ghost.points = poses.transform(scene.T_model_scene, true_points).astype(np.float32)
            middle = true_points.mean(axis=0)
            track = (poses.transform(side.T_model_scene, middle[None])[:, 0]).astype(np.float32)
            self._trail.points = np.stack([track[:-1], track[1:]], axis=1) if len(track) > 1 else _NO_TRAIL
            self._drawn = (run.scene, side.trajectory)
        self._ghost.visible = state.ghost and (inspection is None or inspection.point is None)
        k = side.clipped(iteration)
        T = side.T_model_scene[k]
        self._scene.wxyz = Rotation.from_matrix(T[:3, :3]).as_quat(scalar_first=True)
        self._scene.position = T[:3, 3]
        counted = side.waiting or f"iteration {k} of {side.trajectory.iterations}"
        self._label.text = (
            f"{side.method}\n{counted}\nPointRMSE {side.scores.rmse[k]:.3f}\nPointAcc {side.scores.accuracy[k]:.2f}"
        )

    def _paint(self, run: Run, side: MethodRun, state: State, inspection: Inspection | None) -> None:
        """Colour the model by height or by shares, and the scene by the inspected point's answers."""
        model = side.histogram.model
        self._diagram.draw(model, inspection.point if inspection else None, state.question)
        shares = inspection.of_points if inspection is not None and state.coloring != "height" else None
        plain = (id(model), run.subject.up, state.dark) if shares is None else None
        if plain is None or plain != self._plain:
            height = model.points @ np.array(run.subject.up)
            self._model.colors = _model_colors(height, state.dark) if shares is None else diverging_colors(shares)
            self._plain = plain
        answered = inspection is not None and inspection.point is not None and asked(side.histogram, state.question)
        if answered:
            assert inspection is not None and inspection.point is not None
            first, counts = answers(side.histogram, inspection.moved, inspection.point, state.question)
            colors = answer_colors(first, counts, state.question, state.dark)
            self._points.colors = colors[~run.scene.is_outlier]
            self._outliers.colors = colors[run.scene.is_outlier]
        elif self._answered:
            self._points.colors, self._outliers.colors = np.array(self._color), np.array(palette.OUTLIER)
        self._answered = answered


def point_at(run: Run, origin: FloatArray, direction: FloatArray) -> tuple[Pane, int] | None:
    """The pane and number of the model point that a ray in the 3D view meets."""
    turn = Rotation.from_quat(_upright(run.subject.up), scalar_first=True)
    for pane, x, side in zip(get_args(Pane), (-_PANE_OFFSET, _PANE_OFFSET), run.sides, strict=True):
        points = turn.apply(side.histogram.model.points) + np.array([x, 0.0, 0.0])
        found = point_on_ray(points, origin, direction, _CLICK_REACH)
        if found is not None:
            return pane, found
    return None


def answer_colors(first: BoolArray, counts: FloatArray, question: Question, dark: bool) -> np.ndarray:
    """The block's colour for points on its first side, ink for the others, paler where they count less; (S, 3)."""
    color = palette.BLOCKS[get_args(Question).index(question)]
    full = np.where(first[:, None], np.array(color), np.array(palette.ink(dark)))
    faint = np.array((45, 45, 45) if dark else (228, 228, 228))
    return np.rint(faint + (full - faint) * counts[:, None]).astype(np.uint8)


def _upright(up: tuple[float, float, float]) -> FloatArray:
    """Quaternion (w, x, y, z) that turns a shape's up direction to +z."""
    rotation = Rotation.align_vectors(np.array([[0.0, 0.0, 1.0]]), np.array([up]))[0]
    return rotation.as_quat(scalar_first=True)


def _model_colors(height: FloatArray, dark: bool) -> np.ndarray:
    """Greys by height, so that the shape can be read; shape (M, 3)."""
    share = (height - height.min()) / max(float(np.ptp(height)), 1e-9)
    low, high = (110, 235) if dark else (90, 185)
    return np.repeat((low + (high - low) * share)[:, None], 3, axis=1).astype(np.uint8)
