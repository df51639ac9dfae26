"""Registration: walk the maps until the updates are small (paper, Algorithm 2; docs/method.md, "Registration")."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ido import poses
from ido.histograms import SceneBatch, finite
from ido.maps import Maps
from ido.types import DoubleArray, FloatArray

EPSILON = 1e-3
"""Default stopping threshold of the update norm. The paper says 0.005, which stops DO while it still moves."""

MAX_ITERATIONS = 1000
"""Default limit of all iterations, as in the paper."""

Watch = Callable[[int], None]
"""Called after each iteration with how many there were; what it raises ends the registration."""


class StopReason(StrEnum):
    """Why a registration ended."""

    CONVERGED = "converged"
    MAX_ITERATIONS = "iteration limit"
    DIVERGED = "diverged"
    NOTHING_NEAR = "nothing near"
    """No scene point that a baseline could match."""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """All poses of a registration, from the first to the last.

    Args:
        x: exponential coordinates of T_model_scene before the first update and after each, shape (n + 1, 6).
        update_norms: ‖Δx‖ of each update, shape (n,).
        stop: why it ended.
    """

    x: FloatArray
    update_norms: FloatArray
    stop: StopReason
    last_norm: float
    """‖Δx‖ of the update that was not made any more; NaN where none was computed, as by baselines."""

    @property
    def iterations(self) -> int:
        return len(self.update_norms)

    @property
    def converged(self) -> bool:
        return self.stop is StopReason.CONVERGED

    @property
    def T_model_scene(self) -> FloatArray:
        """All poses, shape (n + 1, 4, 4)."""
        return poses.exp(self.x)


def register(
    maps: Maps,
    points: FloatArray,
    *,
    epsilon: float = EPSILON,
    max_iterations: int = MAX_ITERATIONS,
    x: FloatArray | None = None,
    watch: Watch | None = None,
) -> Trajectory:
    """Register one scene, points (S, 3) in model units, from x (default: where it lies).

    Applies D_1 .. D_K, then D_K until ‖D_K h(x)‖ < ε or max_iterations updates were made in all (docs/method.md, Eq. 13
    and 16); calls `watch` after each.

    Raises:
        ValueError: coordinates are not finite.
    """
    points = finite(points)

    def update(here: DoubleArray, done: int) -> FloatArray:
        return -(maps.maps[min(done, len(maps.maps) - 1)] @ maps.histogram(points, here))

    return iterate(
        update, epsilon=epsilon, max_iterations=max_iterations, at_least=len(maps.maps), start=x, watch=watch
    )


def iterate(
    update: Callable[[DoubleArray, int], FloatArray],
    *,
    epsilon: float,
    max_iterations: int,
    at_least: int = 0,
    start: FloatArray | None = None,
    watch: Watch | None = None,
) -> Trajectory:
    """Repeat x ← x + Δx until ‖Δx‖ < ε (docs/method.md, Eq. 13 and 16), and record every pose.

    Args:
        update: gives Δx (6,) at x (6,), after so many updates.
        epsilon: an update shorter than this is not made any more.
        max_iterations: so many updates at most.
        at_least: so many updates are made however short they are.
        start: the first x (6,); zeros unless given.
        watch: called after each update with how many there were; what it raises ends the registration.
    """
    here: DoubleArray = np.zeros(6) if start is None else np.asarray(start, dtype=np.float64)
    track, norms = [here], []
    stop, last_norm = StopReason.MAX_ITERATIONS, np.nan
    while len(norms) < max_iterations:
        step = update(here, len(norms))
        norm = float(np.sqrt(step @ step))
        diverged = not norm < _LARGEST_UPDATE
        if diverged or (len(norms) >= at_least and norm < epsilon):
            stop, last_norm = StopReason.DIVERGED if diverged else StopReason.CONVERGED, norm
            break
        here = here + step
        track.append(here)
        norms.append(norm)
        if watch:
            watch(len(norms))
    return Trajectory(np.stack(track), np.array(norms), stop, last_norm)


def register_batch(
    maps: Maps, scenes: SceneBatch, *, epsilon: float = EPSILON, max_iterations: int = MAX_ITERATIONS
) -> list[Trajectory]:
    """Register many scenes side by side on all cores; the same results as `register` one by one.

    docs/method.md, Eq. 13 and 16.
    """
    x = np.zeros((len(scenes), 6))
    tracks = [[start.copy()] for start in x]
    norms: list[list[float]] = [[] for _ in tracks]
    stops = [StopReason.MAX_ITERATIONS] * len(tracks)
    last_norms = np.full(len(tracks), np.nan)
    active = np.arange(len(scenes))
    moving = scenes
    for done in range(max_iterations):
        if len(active) == 0:
            break
        k = min(done, len(maps.maps) - 1)
        updates = maps.histogram.batch(moving, x[active]) @ maps.maps[k].T
        sizes = np.sqrt((updates**2).sum(axis=1))
        diverged = ~(sizes < _LARGEST_UPDATE)
        ended = diverged | ((sizes < epsilon) & (done >= len(maps.maps)))
        for i in active[ended]:
            stops[i] = StopReason.CONVERGED
        for i in active[diverged]:
            stops[i] = StopReason.DIVERGED
        last_norms[active[ended]] = sizes[ended]
        on = active[~ended]
        x[on] -= updates[~ended]
        for i, size in zip(on, sizes[~ended], strict=True):
            tracks[i].append(x[i].copy())
            norms[i].append(float(size))
        if ended.any():
            active, moving = on, moving.choose(np.flatnonzero(~ended))
    return [
        Trajectory(np.stack(track), np.array(norm), stop, float(last))
        for track, norm, stop, last in zip(tracks, norms, stops, last_norms, strict=True)
    ]


_LARGEST_UPDATE = 100.0  # far beyond any real one; also false for NaN
