"""The 3D canvas: two panes in one scene, each with the model, the moving scene and where it belongs."""

from __future__ import annotations

import threading

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from ido import Scene, Trajectory, poses
from ido.types import FloatArray
from ido_viz import palette
from ido_viz.run import MethodRun, Run
from ido_viz.state import State

_PANE_OFFSET = 1.5  # of each pane's centre from the middle, model units
_SHOWN_WIDTH = 6.0  # of both panes, and their height: the camera steps back until they fit
_SHOWN_HEIGHT = 3.6
_PORTRAIT = 0.6  # a canvas narrower than this share of its height is a phone's
_NO_TRAIL = np.zeros((1, 2, 3), dtype=np.float32)
_VIEW_DIRECTION = np.array([0.0, -1.0, 0.35])


class Canvas:
    """Draws both panes of one page. Moving a scene sends a pose, not points."""

    def __init__(self, client: viser.ClientHandle) -> None:
        scene = client.scene
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

    def draw(self, run: Run, state: State, iteration: int) -> None:
        """Draw both panes after so many iterations."""
        for pane, side in zip(self._panes, run.sides, strict=True):
            pane.draw(run, side, state, iteration)


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
        self._drawn: tuple[Scene, Trajectory] | None = None
        self._look: tuple[object, ...] | None = None

    def draw(self, run: Run, side: MethodRun, state: State, iteration: int) -> None:
        look = (id(side.histogram), state.shape, state.dark)
        if look != self._look:
            model = side.histogram.model.points
            self._root.wxyz = _upright(run.subject.up)
            self._model.points = model
            self._model.colors = _model_colors(model @ np.array(run.subject.up), state.dark)
            self._look = look
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
        self._ghost.visible = state.ghost
        k = side.clipped(iteration)
        T = side.T_model_scene[k]
        self._scene.wxyz = Rotation.from_matrix(T[:3, :3]).as_quat(scalar_first=True)
        self._scene.position = T[:3, 3]
        counted = side.waiting or f"iteration {k} of {side.trajectory.iterations}"
        self._label.text = (
            f"{side.method}\n{counted}\nPointRMSE {side.scores.rmse[k]:.3f}\nPointAcc {side.scores.accuracy[k]:.2f}"
        )


def _upright(up: tuple[float, float, float]) -> FloatArray:
    """Quaternion (w, x, y, z) that turns a shape's up direction to +z."""
    rotation = Rotation.align_vectors(np.array([[0.0, 0.0, 1.0]]), np.array([up]))[0]
    return rotation.as_quat(scalar_first=True)


def _model_colors(height: FloatArray, dark: bool) -> np.ndarray:
    """Greys by height, so that the shape can be read; shape (M, 3)."""
    share = (height - height.min()) / max(float(np.ptp(height)), 1e-9)
    low, high = (110, 235) if dark else (90, 185)
    return np.repeat((low + (high - low) * share)[:, None], 3, axis=1).astype(np.uint8)
