"""A block of a histogram: what every model point asks of the scene, and its two bins for each."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from ido.clouds import Model
from ido.types import BoolArray, DoubleArray, FloatArray

Color = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

NO_LINES = np.zeros((0, 2, 3))


@dataclass(frozen=True, slots=True)
class Block:
    """Two sides, with a bin each for every model point. Names are all that charts and heatmaps need.

    Args:
        first: name of the first side.
        second: name of the second side.
        color: what it is drawn in; None leaves the choice to who draws it.
    """

    first: str
    second: str
    color: Color | None = None

    @property
    def sides(self) -> tuple[str, str]:
        """The names of both sides."""
        return self.first, self.second

    @property
    def name(self) -> str:
        """Both sides in one line: ``front / back``."""
        return f"{self.first} / {self.second}"


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Where the answer of one model point changes, as a picture in the model frame.

    Args:
        vertices: of a mesh, shape (V, 3), model units.
        faces: its triangles, shape (F, 3).
        lines: in the block's colour, shape (L, 2, 3).
        guides: lines that explain it, such as an axis, shape (G, 2, 3).
    """

    vertices: FloatArray
    faces: np.ndarray
    lines: FloatArray = field(default_factory=lambda: NO_LINES)
    guides: FloatArray = field(default_factory=lambda: NO_LINES)


class Question(Block, ABC):
    """A block whose every bin is a sum over the scene points on its side: Σ w(m_a, s) over s on that side of m_a.

    A new one needs `answers`, `weights` and `surface`; that is its definition, and enough to be trained, inspected and
    drawn. `layout` and `count` are there to be replaced by a compiled loop that does the same.
    """

    __slots__ = ()

    counts_all: ClassVar[bool] = False
    """Whether every scene point counts 1, so that both bins of each model point sum to the number of scene points."""

    @abstractmethod
    def answers(self, points: FloatArray, normals: FloatArray, moved: FloatArray) -> BoolArray:
        """Whether each scene point lies on the first side of each model point.

        Args:
            points: of the model, shape (M, 3).
            normals: of the model, shape (M, 3).
            moved: scene points in the model frame, shape (S, 3).

        Returns:
            shape (M, S).
        """

    @abstractmethod
    def weights(self, points: FloatArray, moved: FloatArray) -> DoubleArray:
        """How much each scene point (S, 3) counts for each model point (M, 3), from 0 to 1; shape (M, S)."""

    @abstractmethod
    def surface(self, point: FloatArray, normal: FloatArray) -> Surface:
        """Where the answer of a model point, (3,) with its normal (3,), changes."""

    def of_point(self, model: Model, point: int, moved: FloatArray) -> tuple[BoolArray, DoubleArray]:
        """What one model point says of moved scene points (S, 3): on the first side or not, and how much each counts.

        Returns:
            two arrays of shape (S,).
        """
        points, normals = (values[[point]].astype(np.float64) for values in (model.points, model.normals))
        return self.answers(points, normals, moved)[0], self.weights(points, moved)[0]

    def sums(self, model: Model, moved: FloatArray) -> DoubleArray:
        """Both bins of every model point, before any scaling, by the definition; shape (2, M)."""
        points, normals = model.points.astype(np.float64), model.normals.astype(np.float64)
        first = self.answers(points, normals, moved)
        weights = self.weights(points, moved)
        return np.stack([(weights * first).sum(axis=1), (weights * ~first).sum(axis=1)])

    def layout(self, model: Model) -> Any:
        """The model as `count` wants it; made once for each model."""
        return model

    def count(self, layout: Any, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int) -> None:
        """Write the `sums` of many scenes into ``out[:, side : side + 2]``.

        Args:
            layout: of the model.
            moved: points of all scenes in the model frame, shape (N, 3), float64.
            starts: scene i is ``moved[starts[i] : starts[i + 1]]``, shape (B + 1,).
            out: shape (B, sides, M), float32.
            side: number of the block's first side.
        """
        for i, (begin, end) in enumerate(pairwise(starts)):
            out[i, side : side + 2] = self.sums(layout, moved[begin:end])


def fan(middle: FloatArray, rim: FloatArray, *, closed: bool) -> tuple[FloatArray, np.ndarray]:
    """Vertices and triangles from a middle (3,) to each edge of a rim (V, 3)."""
    n = len(rim)
    ahead = np.arange(n if closed else n - 1)
    faces = np.stack([np.zeros_like(ahead), 1 + ahead, 1 + (ahead + 1) % n], axis=1)
    return np.concatenate([middle[None], rim]), faces
