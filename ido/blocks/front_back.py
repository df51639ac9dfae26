"""DO's question: does the scene point lie in front of the model point's plane, or behind it?"""

from __future__ import annotations

import numpy as np

from ido.blocks.block import Question, Surface, fan
from ido.blocks.boxes import Boxes, boxes_of, gaussian_weights, weigh
from ido.clouds import Model
from ido.compiling import compiled
from ido.types import BoolArray, DoubleArray, FloatArray

_DISC = 0.35  # radius of the drawn plane, model units
_NORMAL = 0.45  # length of the drawn normal
_AROUND = 48  # corners of the drawn circle


class FrontOrBack(Question):
    """In front when n_a · (s - m_a) > 0; a point counts exp(-‖s - m_a‖²/σ²). docs/method.md, Eq. 5 and 6."""

    __slots__ = ()

    def __init__(self) -> None:
        super().__init__("front", "back", (230, 159, 0))

    def answers(self, points: FloatArray, normals: FloatArray, moved: FloatArray) -> BoolArray:
        return ((moved[None] - points[:, None]) * normals[:, None]).sum(axis=-1) > 0

    def weights(self, points: FloatArray, moved: FloatArray) -> DoubleArray:
        return gaussian_weights(points, moved)

    def surface(self, point: FloatArray, normal: FloatArray) -> Surface:
        """A disc of the local plane, and the normal that stands on it."""
        u = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        u /= np.linalg.norm(u)
        v = np.cross(normal, u)
        angle = np.linspace(0, 2 * np.pi, _AROUND, endpoint=False)[:, None]
        disc = fan(point, point + _DISC * (np.cos(angle) * u + np.sin(angle) * v), closed=True)
        return Surface(*disc, lines=np.array([[point, point + _NORMAL * normal]]))

    def layout(self, model: Model) -> Boxes:
        return boxes_of(model)

    def count(self, layout: Boxes, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int) -> None:
        _count(layout, moved, starts, out, side)


@compiled(inline="always", fastmath=True)
def _is_in_front(  # pragma: no cover (compiled)
    dx: np.float32, dy: np.float32, dz: np.float32, nx: np.float32, ny: np.float32, nz: np.float32
) -> np.bool_:
    return dx * nx + dy * ny + dz * nz > np.float32(0)


@compiled(fastmath=True, error_model="numpy")
def _count(boxes: Boxes, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int) -> None:
    weigh(boxes, moved, starts, out, side, _is_in_front)
