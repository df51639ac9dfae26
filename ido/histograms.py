"""Histograms: what a method sees of a scene at a pose (docs/method.md, "Histograms").

A histogram of the paper's kind is a list of blocks, each a question that all model points ask of the scene. It has a
plain NumPy definition, `describe`, beside the compiled one that is used, `__call__` and `batch`.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np

from ido import kernels, poses
from ido.blocks import Block, ClockwiseOrAnticlockwise, FrontOrBack, Question, UpOrDown
from ido.blocks.near_far import NearOrFar
from ido.clouds import Model
from ido.types import FloatArray

_SCENES_A_THREAD = 8
_SCENES_AT_ONCE = 64  # whose moved points stay in the processor's cache from one block to the next

Normalisation = Literal["unit-norm", "unit-sum"]


def finite(points: FloatArray) -> FloatArray:
    """Points as the compiled loops want them: float32, in one piece, and none that would lead them out of bounds.

    Raises:
        ValueError: coordinates are not finite.
    """
    points = np.ascontiguousarray(points, dtype=np.float32)
    if not np.isfinite(points).all():
        raise ValueError("the scene has coordinates that are not finite; remove those points first")
    return points


@dataclass(frozen=True, slots=True, eq=False)
class SceneBatch:
    """Many scenes in one array: scene i is ``points[starts[i]:starts[i + 1]]``."""

    points: FloatArray
    starts: np.ndarray

    @classmethod
    def of(cls, scenes: Sequence[FloatArray]) -> SceneBatch:
        """Pack scenes, each of shape (S_i, 3).

        Raises:
            ValueError: coordinates are not finite.
        """
        starts = np.concatenate([[0], np.cumsum([len(scene) for scene in scenes])]).astype(np.int64)
        return cls(finite(np.concatenate([*scenes, np.empty((0, 3))])), starts)

    def __len__(self) -> int:
        return len(self.starts) - 1

    def __getitem__(self, i: int) -> FloatArray:
        return self.points[self.starts[i] : self.starts[i + 1]]

    def part(self, begin: int, end: int) -> SceneBatch:
        """Scenes begin to end, without copying."""
        starts = self.starts[begin : end + 1]
        return SceneBatch(self.points[starts[0] : starts[-1]], starts - starts[0])

    def choose(self, chosen: np.ndarray) -> SceneBatch:
        """The chosen scenes, copied."""
        return SceneBatch.of([self[i] for i in chosen])


class Histogram(ABC):
    """A feature of a scene relative to a model. A new one needs a name, `blocks` and `describe`.

    Where every bin is a sum over scene points, `BlockHistogram` does the describing: it needs a name and `blocks`.

    Args:
        model: the model that it is relative to.
    """

    name: ClassVar[str]
    blocks: ClassVar[tuple[Block, ...]]
    """Each has 2 M bins, the first M for its first side."""

    def __init__(self, model: Model) -> None:
        self.model = model

    @abstractmethod
    def describe(self, moved: FloatArray) -> FloatArray:
        """The histogram of points (S, 3) in the model frame; shape (n_bins,)."""

    def __call__(self, points: FloatArray, x: FloatArray) -> FloatArray:
        """The histogram of a scene (S, 3) moved by exponential coordinates x (6,); shape (n_bins,), float32."""
        return self.describe(poses.transform(poses.exp(x), points)).astype(np.float32)

    def batch(self, scenes: SceneBatch, x: FloatArray) -> FloatArray:
        """Histograms of many scenes, moved by x (B, 6); shape (B, n_bins), float32."""
        rows = [self(scenes[i], x[i]) for i in range(len(scenes))]
        return np.stack(rows) if rows else np.empty((0, self.n_bins), dtype=np.float32)

    @property
    def side_names(self) -> tuple[str, ...]:
        """Of all blocks, in the order of the bins, M for each."""
        return tuple(side for block in self.blocks for side in block.sides)

    @cached_property
    def questions(self) -> tuple[Question, ...]:
        """The blocks that can be asked about a single pair of points."""
        return tuple(block for block in self.blocks if isinstance(block, Question))

    @property
    def n_bins(self) -> int:
        return 2 * len(self.blocks) * len(self.model.points)

    @cached_property
    def reference(self) -> FloatArray:
        """The reference line: the histogram of the model against itself, shape (n_bins,) (docs/method.md, Eq. 11)."""
        return self(self.model.points, np.zeros(6))


class BlockHistogram(Histogram):
    """A histogram whose blocks all are questions: their sums, weighed, each block scaled (docs/method.md, Eq. 9)."""

    normalisation: ClassVar[Normalisation] = "unit-norm"

    @cached_property
    def weights(self) -> FloatArray:
        """Weight of each bin, shape (sides, M)."""
        return np.ones((2 * len(self.blocks), len(self.model.points)), dtype=np.float32)

    @cached_property
    def _layouts(self) -> tuple[Any, ...]:
        return tuple(question.layout(self.model) for question in self.questions)

    def __call__(self, points: FloatArray, x: FloatArray) -> FloatArray:
        points = np.ascontiguousarray(points, dtype=np.float32)
        out = np.empty((1, *self.weights.shape), dtype=np.float32)
        self._fill(points, np.array([0, len(points)]), np.ascontiguousarray(x, dtype=np.float64)[None], out)
        return out.reshape(-1)

    def batch(self, scenes: SceneBatch, x: FloatArray) -> FloatArray:
        x = np.ascontiguousarray(x, dtype=np.float64)
        out = np.empty((len(scenes), *self.weights.shape), dtype=np.float32)
        n_threads = min(os.cpu_count() or 1, -(-len(scenes) // _SCENES_A_THREAD))
        step = min(max(_SCENES_A_THREAD, -(-len(scenes) // (4 * max(n_threads, 1)))), _SCENES_AT_ONCE)
        begins = range(0, len(scenes), step)

        def fill(begin: int) -> None:
            part = scenes.part(begin, min(begin + step, len(scenes)))
            end = begin + len(part)
            self._fill(part.points, part.starts, x[begin:end], out[begin:end])

        if n_threads > 1:  # a pool for each call: a lasting one would not survive a fork
            _ = self._layouts, self.weights  # made once, before the threads want them
            with ThreadPoolExecutor(n_threads) as pool:
                list(pool.map(fill, begins))
        else:
            for begin in begins:
                fill(begin)
        return out.reshape(len(scenes), -1)

    def _fill(self, points: FloatArray, starts: np.ndarray, x: FloatArray, out: FloatArray) -> None:
        """Write the histograms of scenes, moved by x (B, 6), to `out` (B, sides, M)."""
        moved = kernels.move(points, starts, x)
        for i, (question, layout) in enumerate(zip(self.questions, self._layouts, strict=True)):
            question.count(layout, moved, starts, out, 2 * i)
        kernels.scale_blocks(out, self.weights, self.normalisation == "unit-norm")

    def describe(self, moved: FloatArray) -> FloatArray:
        blocks = (self.sides(np.asarray(moved, dtype=np.float64)) * self.weights).reshape(len(self.blocks), -1)
        size = np.linalg.norm(blocks, axis=1) if self.normalisation == "unit-norm" else blocks.sum(axis=1)
        return (blocks / np.where(size > 0, size, 1.0)[:, None]).reshape(-1)

    def sides(self, moved: FloatArray) -> FloatArray:
        """The blocks before weighing and scaling, of points (S, 3) in the model frame; shape (sides, M)."""
        return np.concatenate([question.sums(self.model, moved) for question in self.questions])


class FrontBack(BlockHistogram):
    """DO: how much of the scene lies in front of each model point, and how much behind it (docs/method.md, Eq. 6)."""

    name = "front-back"
    blocks = (FrontOrBack(),)


class TripleBinary(BlockHistogram):
    """Improved DO: front / back, and how many scene points lie above / below and clockwise / anticlockwise.

    docs/method.md, Eq. 6 and 8.
    """

    name = "triple-binary"
    blocks = (FrontOrBack(), UpOrDown(), ClockwiseOrAnticlockwise())


class AsPrinted(TripleBinary):
    """Improved DO with the paper's weights: α, β, γ on the first sides, 1-α, 1-β, 1-γ on the second ones.

    α_a, β_a, γ_a are the shares of the model points in front of, above and clockwise of m_a (docs/method.md, Eq. 10).
    """

    name = "as-printed"

    @cached_property
    def weights(self) -> FloatArray:
        points, normals = self.model.points.astype(np.float64), self.model.normals.astype(np.float64)
        shares = [question.answers(points, normals, points).mean(axis=1) for question in self.questions]
        return np.concatenate([[share, 1 - share] for share in shares]).astype(np.float32)


class QuadrupleBinary(BlockHistogram):
    """Improved DO with a question more, which is not the paper's: near / far (docs/method.md, Eq. 6, 8 and 12)."""

    name = "quadruple-binary"
    blocks = (*TripleBinary.blocks, NearOrFar())


HISTOGRAMS: dict[str, type[Histogram]] = {h.name: h for h in (FrontBack, TripleBinary, AsPrinted, QuadrupleBinary)}
"""The histograms that a maps file may name."""
