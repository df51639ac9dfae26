"""Points and lines drawn in perspective, as seen on the canvas, into a picture of numbered colours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import ImageDraw

from ido.types import DoubleArray, FloatArray
from ido_viz.core.geometry import VIEW_DIRECTION, upright

_EYE = 5.0  # distance of the eye from the model's centre, model units
_NEAREST = 2.0  # what is nearer to the eye is not drawn
_REACH = 1.8  # the picture reaches at most so far from the model's centre, model units
_ROOM = 1.06  # around what must be in sight
_AT_ONCE = 200  # discs; their sizes differ little, so that few pixels are tried in vain


@dataclass(frozen=True, slots=True, eq=False)
class Dots:
    """Points that are drawn as discs.

    Args:
        points: shape (n, 3), model units.
        colors: numbers of their colours, shape (n,).
        radius: model units.
        rim: width of an edge of colour 0, the page's, that sets them off from what is behind; pixels.
        ahead: they cover others as if they were so much nearer, model units.
    """

    points: FloatArray
    colors: np.ndarray
    radius: float
    rim: float = 0.0
    ahead: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """How model units become pixels.

    Args:
        turn: to the right, up and towards the eye, shape (3, 3).
        centre: what is in the middle of the picture, in the plane through the model's centre, shape (2,).
        scale: pixels of a model unit in that plane.
        size: width and height of the picture, pixels.
    """

    turn: DoubleArray
    centre: DoubleArray
    scale: float
    size: tuple[int, int]

    @classmethod
    def over(cls, points: FloatArray, up: tuple[float, float, float], size: tuple[int, int]) -> View:
        """The nearest view, from the canvas's direction, that has points (n, 3) in sight, but none too far away."""
        toward = VIEW_DIRECTION / np.linalg.norm(VIEW_DIRECTION)
        right = np.cross([0.0, 0.0, 1.0], toward)
        right /= np.linalg.norm(right)
        seen = np.stack([right, np.cross(toward, right), toward])
        turn = seen @ upright(up).as_matrix()
        flat, _ = _flattened(np.clip(np.nan_to_num(points), -_REACH, _REACH) @ turn.T)
        low, high = flat.min(axis=0), flat.max(axis=0)
        scale = float((np.array(size) / (_ROOM * (high - low))).min())
        return cls(turn, (low + high) / 2, scale, size)

    def project(self, points: FloatArray) -> tuple[DoubleArray, DoubleArray]:
        """Places (n, 2) in the picture and pixels of a model unit there (n,): 0 if too near to the eye.

        Places count from the upper left corner, the middle of the first pixel being (0, 0).
        """
        flat, larger = _flattened(points @ self.turn.T)
        places = (flat - self.centre) * (self.scale, -self.scale) + (np.array(self.size) - 1) / 2
        return places, larger * self.scale

    def draw_lines(self, pixels: ImageDraw.ImageDraw, ends: FloatArray, color: int, width: int) -> None:
        """Draw lines between pairs of points, shape (n, 2, 3), all of one width in pixels."""
        places, scales = self.project(ends.reshape(-1, 3))
        sane = (scales.reshape(-1, 2) > 0).all(axis=1) & (np.abs(places.reshape(-1, 4)) < 1e5).all(axis=1)
        for line in places.reshape(-1, 4)[sane].tolist():
            pixels.line(line, fill=color, width=width)

    def stamp(self, pixels: np.ndarray, layers: Sequence[Dots]) -> np.ndarray:
        """Colours, shape (height, width), with discs drawn over them, what is farther away first."""
        places, scales = self.project(np.concatenate([dots.points for dots in layers]))
        radii = np.concatenate([np.full(len(dots.points), dots.radius) for dots in layers]) * scales
        edges = radii + np.concatenate([np.full(len(dots.points), dots.rim) for dots in layers])
        colors = np.concatenate([dots.colors for dots in layers]).astype(pixels.dtype)
        inside = (scales > 0) & (places > -0.5).all(axis=1) & (places < np.array(self.size) - 0.5).all(axis=1)
        nearness = scales * (1 + np.concatenate([np.full(len(dots.points), dots.ahead) for dots in layers]) / _EYE)
        order = np.flatnonzero(inside)[np.argsort(nearness[inside], kind="stable")]
        margin = int(np.ceil(edges[order].max(initial=0.0))) + 1
        drawn = np.pad(pixels, margin)  # so that discs may reach over the edge
        for some in np.array_split(order, max(len(order) // _AT_ONCE, 1)):
            _stamp(drawn, places[some] + margin, radii[some], edges[some], colors[some])
        return drawn[margin:-margin, margin:-margin]


def _stamp(pixels: np.ndarray, places: DoubleArray, radii: DoubleArray, edges: DoubleArray, colors: np.ndarray) -> None:
    """Draw discs into colours, one over the other; nothing may reach over the edge."""
    reach = int(np.ceil(edges.max(initial=0.0)))
    steps = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * 2), axis=-1).reshape(-1, 2)
    pixel = np.rint(places).astype(np.int64)
    off = (places - pixel).astype(np.float32)
    squares = (steps**2).sum(axis=1) - 2 * off @ steps.T.astype(np.float32) + (off**2).sum(axis=1)[:, None]
    which, step = np.nonzero(squares <= (edges**2)[:, None])
    colored = np.where(squares[which, step] <= (radii**2)[which], colors[which], colors.dtype.type(0))
    x, y = (pixel[which] + steps[step]).T
    pixels[y, x] = colored  # where several are drawn, the last one stays


def _flattened(seen: FloatArray) -> tuple[DoubleArray, DoubleArray]:
    """Turned points (n, 3) in the plane through the centre (n, 2), and how much larger they look there (n,)."""
    seen = seen.astype(np.float64)
    distance = _EYE - seen[:, 2]
    larger = np.where(distance > _NEAREST, _EYE / np.maximum(distance, _NEAREST), 0.0)
    return seen[:, :2] * larger[:, None], larger
