"""The paper's "triple-binary" diagram at a model point: its plane and normal, elevation cone, azimuth half-plane."""

from __future__ import annotations

import numpy as np
import viser

from ido import Model
from ido.types import FloatArray
from ido_viz import palette
from ido_viz.state import Question

_REACH = 1.2  # of the cone and the half-plane, model units
_DISC = 0.35  # radius of the local plane
_AROUND = 48  # corners of a circle


class Diagram:
    """Draws the diagram of one pane, in the model's frame under a node."""

    def __init__(self, scene: viser.SceneApi, root: str) -> None:
        self._scene = scene
        self._root = f"{root}/diagram"
        self._shown: tuple[object, ...] | None = None

    def draw(self, model: Model, point: int | None, question: Question, partner: FloatArray | None = None) -> None:
        """Draw the diagram of a model point and one of its questions; nothing for None.

        Args:
            model: whose point it is.
            point: its number.
            question: one of its questions.
            partner: the one scene point that it is asked about, in the model's frame, shape (3,).
        """
        look = (id(model), point, question, None if partner is None else partner.tobytes())
        if look == self._shown:
            return
        self._shown = look
        self._scene.remove_by_name(self._root)
        if point is None:
            return
        m, n = model.points[point].astype(np.float64), model.normals[point].astype(np.float64)
        self._scene.add_frame(self._root, show_axes=False)
        self._scene.add_icosphere(f"{self._root}/point", radius=0.045, color=palette.MARK, position=m)
        if question == "front / back":
            self._surface(*disc(m, n), palette.BLOCKS[0])
            self._lines("normal", np.array([[m, m + 0.45 * n]]), palette.BLOCKS[0])
        elif question == "up / down":
            self._surface(*cone(m), palette.BLOCKS[1])
        else:
            self._surface(*half_plane(m), palette.BLOCKS[2])
        if question != "front / back":
            axis = np.array([[[0.0, 0.0, -_REACH], [0.0, 0.0, _REACH]], [[0.0, 0.0, 0.0], m]])
            self._lines("axis", axis, (128, 128, 128))
        if partner is not None:
            self._scene.add_icosphere(f"{self._root}/partner", radius=0.035, color=palette.MARK, position=partner)
            self._lines("pair", np.array([[m, partner]]), palette.MARK)

    def _surface(self, vertices: FloatArray, faces: np.ndarray, color: palette.Color) -> None:
        self._scene.add_mesh_simple(
            f"{self._root}/surface",
            vertices.astype(np.float32),
            faces.astype(np.uint32),
            color=color,
            opacity=0.3,
            side="double",
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )

    def _lines(self, name: str, segments: FloatArray, color: palette.Color) -> None:
        self._scene.add_line_segments(
            f"{self._root}/{name}",
            segments.astype(np.float32),
            np.array(color),
            thickness=3.0,
            thickness_units="screen",
        )


def disc(m: FloatArray, n: FloatArray) -> tuple[FloatArray, np.ndarray]:
    """The local plane: vertices (V, 3) and faces (F, 3) of a disc around m that n stands on."""
    u = np.cross(n, np.eye(3)[np.abs(n).argmin()])
    u /= np.linalg.norm(u)
    v = np.cross(n, u)
    angle = np.linspace(0, 2 * np.pi, _AROUND, endpoint=False)[:, None]
    return _fan(m, m + _DISC * (np.cos(angle) * u + np.sin(angle) * v), closed=True)


def cone(m: FloatArray) -> tuple[FloatArray, np.ndarray]:
    """All directions from the origin with the elevation of m: vertices and faces of a cone around z."""
    elevation = np.arctan2(m[2], np.hypot(m[0], m[1]))
    angle = np.linspace(0, 2 * np.pi, _AROUND, endpoint=False)
    flat = np.cos(elevation)
    rim = _REACH * np.stack([flat * np.cos(angle), flat * np.sin(angle), np.full(_AROUND, np.sin(elevation))], axis=1)
    return _fan(np.zeros(3), rim, closed=True)


def half_plane(m: FloatArray) -> tuple[FloatArray, np.ndarray]:
    """All points with the azimuth of m: vertices and faces of a rectangle from the z axis outwards."""
    azimuth = np.arctan2(m[1], m[0])
    out = _REACH * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    up = np.array([0.0, 0.0, _REACH])
    return _fan(-up, np.stack([out - up, out + up, up]), closed=False)


def _fan(middle: FloatArray, rim: FloatArray, *, closed: bool) -> tuple[FloatArray, np.ndarray]:
    """Triangles from a middle to each edge of a rim (V, 3)."""
    n = len(rim)
    ahead = np.arange(n if closed else n - 1)
    faces = np.stack([np.zeros_like(ahead), 1 + ahead, 1 + (ahead + 1) % n], axis=1)
    return np.concatenate([middle[None], rim]), faces
