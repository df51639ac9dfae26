"""The starts of a method from any start as small darts that converge, and the fan of poses that its end may be."""

from __future__ import annotations

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from ido import Scene, poses
from ido.types import DoubleArray, FloatArray
from ido_viz.core import palette
from ido_viz.core.frame import SideFrame
from ido_viz.core.geometry import upright
from ido_viz.core.race import Race, fan_of
from ido_viz.core.run import MethodRun

_DART = (  # points to the front of an upright model, -y, and is flat, so that its turn is seen
    np.array([[0, -0.11, 0], [0.035, 0.04, 0], [-0.035, 0.04, 0], [0, 0.03, 0.02]], dtype=np.float32),
    np.array([[0, 1, 3], [0, 3, 2], [1, 2, 3], [0, 2, 1]], dtype=np.uint32),
)
_ABOVE = np.array([0.0, 0.0, 1.1])  # where a dart flies over an upright model
_FAN_POINTS = 120  # of the scene, at each pose of the fan
_GONE = np.float32(1e-4)  # size of a dart that is out of the race
_NONE = np.zeros((1, 3), dtype=np.float32)


class RaceView:
    """Draws the race and the fan of one pane, in the model's frame under a node.

    Each dart flies over the top of the model, as the scene would have it if its start were right. So darts that agree
    are in one place, over the top of the model, and point to the front.
    """

    def __init__(self, scene: viser.SceneApi, root: str) -> None:
        self._darts = scene.add_batched_meshes_simple(
            f"{root}/race",
            *_DART,
            batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
            batched_positions=_NONE,
            batched_opacities=np.zeros(1, dtype=np.float32),
            flat_shading=True,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._fan = scene.add_point_cloud(
            f"{root}/fan", _NONE, palette.GUIDE, point_size=0.012, point_shape="circle", visible=False
        )
        self._run: MethodRun | None = None
        self._dark = False
        self._T_dart = np.empty((0, 0, 4, 4))
        self._k = -1

    def draw(self, scene: Scene, side: SideFrame, up: tuple[float, float, float], dark: bool) -> None:
        """Draw the starts of a side after its iterations, and the fan at its end; nothing for other methods."""
        if side.run is not self._run or dark != self._dark:
            self._place(scene, side.run, up, dark)
        self._fan.visible = side.run.confidence is not None and side.k == side.run.trajectory.iterations
        race = side.run.race
        self._darts.visible = race is not None and side.k > 0
        if race is None or side.k in (0, self._k):
            return
        self._k = side.k
        T = self._T_dart[:, race.step(side.k)]
        self._darts.batched_positions = T[:, :3, 3].astype(np.float32)
        self._darts.batched_wxyzs = Rotation.from_matrix(T[:, :3, :3]).as_quat(scalar_first=True).astype(np.float32)
        strength = race.strength(side.k).astype(np.float32)
        self._darts.batched_opacities = strength
        self._darts.batched_scales = np.where(strength > 0, np.float32(1.0), _GONE)  # what cannot be seen hides others

    def _place(self, scene: Scene, run: MethodRun, up: tuple[float, float, float], dark: bool) -> None:
        """Take over another run, and draw what stays where it is while it is played."""
        self._run, self._dark, self._k = run, dark, -1
        color = palette.method_color(run.method, dark)
        if run.race is not None:
            self._T_dart = darts(run.race, run.T_model_scene[-1], up)
            self._darts.batched_colors = np.array(palette.text(color, dark), dtype=np.uint8)
        if run.confidence is not None:
            true_points = scene.points[~scene.is_outlier]
            few = true_points[:: -(-len(true_points) // _FAN_POINTS)]
            fan = fan_of(run.confidence, run.T_model_scene[-1])
            self._fan.points = poses.transform(fan, few).reshape(-1, 3).astype(np.float32)
            self._fan.colors = np.array(palette.lighter(color, dark, 0.3), dtype=np.uint8)


def darts(race: Race, T_model_scene: FloatArray, up: tuple[float, float, float]) -> DoubleArray:
    """Where each start's dart is at each step in the model's frame, shape (n, steps + 1, 4, 4).

    Args:
        race: of the starts.
        T_model_scene: the pose that was chosen, shape (4, 4): there, a dart is over the top of the model.
        up: the model's.
    """
    T_model_dart = np.eye(4)
    T_model_dart[:3, :3] = upright(up).inv().as_matrix()
    T_model_dart[:3, 3] = upright(up).inv().apply(_ABOVE)
    return race.T_model_scene @ (poses.invert(T_model_scene) @ T_model_dart)
