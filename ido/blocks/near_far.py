"""A question that is not the paper's: does the scene point lie within σ of the model point, or further away?"""

from __future__ import annotations

import numpy as np

from ido.blocks.block import Question, Surface
from ido.blocks.boxes import SCALED_SIGMA2, SIGMA2, Boxes, boxes_of, gaussian_weights, weigh
from ido.clouds import Model
from ido.compiling import compiled
from ido.types import BoolArray, DoubleArray, FloatArray


class NearOrFar(Question):
    """Near when ‖s - m_a‖ < σ; a point counts exp(-‖s - m_a‖²/σ²). docs/method.md, Eq. 5 and 12.

    It weighs as front / back does. Plain counts would put nearly all points on the far side of every model point, and
    a block that is scaled to length 1 would have next to nothing left for the near ones.
    """

    __slots__ = ()

    def __init__(self) -> None:
        super().__init__("near", "far", (170, 120, 60))

    def answers(self, points: FloatArray, normals: FloatArray, moved: FloatArray) -> BoolArray:
        return ((moved[None] - points[:, None]) ** 2).sum(axis=-1) < SIGMA2

    def weights(self, points: FloatArray, moved: FloatArray) -> DoubleArray:
        return gaussian_weights(points, moved)

    def surface(self, point: FloatArray, normal: FloatArray) -> Surface:
        """A sphere of radius σ."""
        import trimesh  # takes a while to import

        sphere = trimesh.creation.icosphere(subdivisions=3, radius=np.sqrt(SIGMA2))
        return Surface(np.asarray(sphere.vertices) + point, np.asarray(sphere.faces))

    def layout(self, model: Model) -> Boxes:
        return boxes_of(model)

    def count(self, layout: Boxes, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int) -> None:
        _count(layout, moved, starts, out, side)


@compiled(inline="always", fastmath=True)
def _is_near(  # pragma: no cover (compiled)
    dx: np.float32, dy: np.float32, dz: np.float32, nx: np.float32, ny: np.float32, nz: np.float32
) -> np.bool_:
    return dx * dx + dy * dy + dz * dz < np.float32(SCALED_SIGMA2)


@compiled(fastmath=True, error_model="numpy")
def _count(boxes: Boxes, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int) -> None:
    weigh(boxes, moved, starts, out, side, _is_near)
