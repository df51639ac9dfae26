"""The search: many rotations, each with all translations at once, by Fourier transforms (docs/global.md, Eq. 3)."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import scipy  # a part of it is loaded when it is used: the program starts sooner
from scipy.spatial.transform import Rotation

from ido.global_registration.fields import REACH, Field, deposit, read
from ido.global_registration.outliers import Background
from ido.perturbation import OUTLIER_REACH
from ido.types import DoubleArray, FloatArray

SIDE = 4.0
"""Length of the cube, periodic, that translations are searched in (model units)."""

_FINE, _COARSE = 32, 20  # cells a side: where points are counted, and where translations are told apart
_PEAKS = 2  # translations of each rotation
_BATCH = 32  # rotations at a time, whose transforms stay in the processor's cache


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """The turned models' transforms, made once for a model (docs/global.md, Eq. 3).

    Args:
        rotations: R of T_model_scene, shape (n, 3, 3).
        spectra: low frequencies of the turned score fields' transforms, conjugate, shape (n, 20, 20, 11), complex64.
    """

    rotations: DoubleArray
    spectra: np.ndarray

    @classmethod
    def of(cls, field: Field, n_rotations: int) -> Search:
        """The search for a model's field: a point of density p scores log(1 + p / 2u), u that of scattered outliers."""
        uniform = 1 / (2 * OUTLIER_REACH) ** 3
        scores = np.log1p(field.density / np.float32(2 * uniform))
        rotations = spread_rotations(n_rotations)
        axis = np.fft.fftfreq(_FINE, 1 / SIDE).astype(np.float32)
        lattice = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)

        def spectrum(R: DoubleArray) -> np.ndarray:
            turned = np.empty(len(lattice), dtype=np.float32)
            read(lattice @ R.T.astype(np.float32), scores, REACH, field.step, turned)
            return _low(np.asarray(scipy.fft.rfftn(turned.reshape(_FINE, _FINE, _FINE)))).conj()

        with ThreadPoolExecutor() as pool:
            return cls(rotations, np.stack(list(pool.map(spectrum, rotations))))

    def __call__(self, points: FloatArray, backgrounds: Sequence[Background]) -> list[tuple[DoubleArray, FloatArray]]:
        """The best two translations of each rotation, for points (S, 3) near the origin and each of their backgrounds.

        Returns:
            for each background poses T_model_scene, shape (2 n, 4, 4), and their scores, shape (2 n,).
        """
        return [self._of(points, background) for background in backgrounds]

    def _of(self, points: FloatArray, background: Background) -> tuple[DoubleArray, FloatArray]:
        counts = np.zeros((_FINE + 1,) * 3, dtype=np.float32)
        deposit(np.ascontiguousarray(points, dtype=np.float32), 1 - background.in_ball, SIDE / 2, SIDE / _FINE, counts)
        counts[0] += counts[-1]  # the cube is periodic
        counts[:, 0] += counts[:, -1]
        counts[:, :, 0] += counts[:, :, -1]
        scene = _low(np.asarray(scipy.fft.rfftn(counts[:-1, :-1, :-1])))

        def best(begin: int) -> tuple[np.ndarray, np.ndarray]:
            batch = self.spectra[begin : begin + _BATCH] * scene
            return _peaks(np.asarray(scipy.fft.irfftn(batch, s=(_COARSE,) * 3, axes=(1, 2, 3), overwrite_x=True)))

        with ThreadPoolExecutor() as pool:
            parts = list(pool.map(best, range(0, len(self.spectra), _BATCH)))
        cells = np.concatenate([found for found, _ in parts])  # (n, peaks, 3)
        # the scene was counted from the corner of the cube, the model from its middle
        centres = cells * (SIDE / _COARSE) - SIDE / 2
        centres -= SIDE * np.floor(centres / SIDE + 0.5)
        rotations = np.repeat(self.rotations, _PEAKS, axis=0)
        centres = centres.reshape(-1, 3)
        T = np.tile(np.eye(4), (len(centres), 1, 1))
        T[:, :3, :3] = rotations
        T[:, :3, 3] = -np.einsum("nij,nj->ni", rotations, centres)
        return T, np.concatenate([scores for _, scores in parts]).reshape(-1)


def spread_rotations(n: int) -> DoubleArray:
    """Rotations spread evenly over all (super-Fibonacci spirals, Alexa 2022); shape (n, 3, 3)."""
    s = np.arange(n) + 0.5
    first, second = np.sqrt(2.0), 1.533751168755204288118041  # the real root of x⁴ = x + 4
    inner, outer = np.sqrt(s / n), np.sqrt(1 - s / n)
    a, b = 2 * np.pi * s / first, 2 * np.pi * s / second
    quaternions = np.stack([inner * np.sin(a), inner * np.cos(a), outer * np.sin(b), outer * np.cos(b)], axis=1)
    return Rotation.from_quat(quaternions).as_matrix()


def _peaks(scores: FloatArray) -> tuple[np.ndarray, FloatArray]:
    """The highest cells of scores (n, c, c, c), each outside the neighbourhood of those before.

    Returns:
        the cells, shape (n, _PEAKS, 3), and their scores, shape (n, _PEAKS).
    """
    rows = np.arange(len(scores))
    cells, heights = np.empty((len(scores), _PEAKS, 3), dtype=int), np.empty((len(scores), _PEAKS))
    around = np.stack(np.meshgrid(*[np.arange(-2, 3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for peak in range(_PEAKS):
        found = scores.reshape(len(scores), -1).argmax(axis=1)
        cells[:, peak] = np.stack(np.unravel_index(found, scores.shape[1:]), axis=1)
        heights[:, peak] = scores[rows, *cells[:, peak].T]
        i, j, k = ((cells[:, peak, None] + around) % _COARSE).transpose(2, 0, 1)
        scores[rows[:, None], i, j, k] = -np.inf
    return cells, heights


def _low(spectrum: np.ndarray) -> np.ndarray:
    """The low frequencies of a transform on the fine grid, as one on the coarse grid has them."""
    half = _COARSE // 2
    kept = np.concatenate([np.arange(half), np.arange(_FINE - half, _FINE)])
    low = spectrum[np.ix_(kept, kept, np.arange(half + 1))]
    low[half, :, :] = low[:, half, :] = low[:, :, half] = 0  # which have no counterpart
    return np.ascontiguousarray(low)
