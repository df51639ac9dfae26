"""How well a registered cloud lies on the model, and what of its pose cannot be known: figures and warnings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from ido.maps import Maps
from ido.poses import transform
from ido.registration import register
from ido.types import FloatArray

NEAR = 0.1
"""Distance from the model's points within which a point fits them, as in PointAcc (model units)."""

POOR_SHARE = 0.3
"""A fit is doubted when a smaller share of the cloud, or of the model, is near the other."""

POOR_BOTH = 0.4
"""A fit is doubted when both shares are smaller. At the paper's test defaults both are above it for right poses."""

GOOD_SHARE = 0.9
"""A fit with more of the cloud and the model near each other is not compared with that of changed clouds."""

CLEARLY = 0.1
"""A changed cloud fits better when its fit is greater by this share."""

OTHER_SIZE = 1.25
"""A cloud whose spread is more than this multiple of the model's, or less than its inverse, may be in other units."""

FLAT = 0.03
"""A cloud that spreads less along an axis, as part of its greatest spread, has no extent there."""

COARSE = 0.02
"""Step of the coordinates, in model units, beyond which they have lost digits."""

DENSE = 0.15
"""Share of the points within `NEAR` of one of them, beyond which the others hardly count."""

ALIKE = 0.97
"""A model looks the same after a turn when this share of its points is near others of it."""

_ITERATIONS, _FEW = 100, 1000  # enough, also of points, to see whether a changed cloud fits


@dataclass(frozen=True, slots=True)
class Fit:
    """How near a cloud and the model are to each other.

    Args:
        near_share: share of the cloud's points within `NEAR` of a model point.
        near_rmse: root mean square of the distances of those, in the units of the maps' cloud; NaN when there are none.
        covered_share: share of the model's points within `NEAR` of a point of the cloud.
    """

    near_share: float
    near_rmse: float
    covered_share: float

    @property
    def mutual(self) -> float:
        """The smaller of the two shares."""
        return min(self.near_share, self.covered_share)


@dataclass(frozen=True, slots=True)
class Extent:
    """What a cloud's own points allow, in the user's units.

    Args:
        spread: standard deviation along the three principal axes, greatest first.
        size_ratio: its spread over all axes, as multiple of the model's; outliers add to it, missing parts take away.
        step: the largest, over the axes, of the smallest steps between different coordinates: that of rounded digits.
        densest_share: share of the points within `NEAR` of one of them.
    """

    spread: tuple[float, float, float]
    size_ratio: float
    step: float
    densest_share: float


@dataclass(frozen=True, slots=True)
class Quality:
    """All that is said about a registered cloud besides its pose."""

    fit: Fit
    extent: Extent
    warnings: tuple[str, ...]


def quality(maps: Maps, points: FloatArray, T_model_scene: FloatArray) -> Quality:
    """Judge a pose.

    Args:
        maps: that found it.
        points: what was registered, shape (S, 3), user's units.
        T_model_scene: the pose in the user's units, shape (4, 4).
    """
    scene = maps.frame.to_model_units(points)
    placed = maps.frame.to_model_units(transform(T_model_scene, points))
    fit, extent = fit_of(maps, placed), _extent(maps, scene)
    warnings = [*_of_fit(maps, scene, placed, fit, extent), *_of_extent(maps, extent), *_of_model(maps)]
    return Quality(fit, extent, tuple(warnings))


def fit_of(maps: Maps, placed: FloatArray) -> Fit:
    """How near a cloud lies to the model, points (S, 3) in model units."""
    model = maps.histogram.model.points
    distance = KDTree(model).query(placed)[0]
    near = distance[distance <= NEAR]
    rmse = maps.frame.scale * float(np.sqrt((near**2).mean())) if len(near) else float("nan")
    covered = KDTree(placed).query(model)[0] <= NEAR
    return Fit(len(near) / len(placed), rmse, float(covered.mean()))


def _extent(maps: Maps, scene: FloatArray) -> Extent:
    model, scale = maps.histogram.model.points, maps.frame.scale
    spread = np.sqrt(np.linalg.eigvalsh(np.cov(scene.T)).clip(0))[::-1]
    total = float(np.sqrt(scene.var(axis=0).sum() / model.var(axis=0).sum()))
    within = KDTree(scene).query_ball_point(scene, NEAR, return_length=True)
    first, second, third = (float(value) for value in spread * scale)
    return Extent((first, second, third), total, _step(scene) * scale, float(np.max(within)) / len(scene))


def _step(scene: FloatArray) -> float:
    """Coordinates that are not rounded come so close to each other that it is nearly 0."""
    different = [np.unique(coordinates) for coordinates in scene.T]
    return max((float(np.diff(values).min()) for values in different if len(values) > 1), default=0.0)


def _of_fit(maps: Maps, scene: FloatArray, placed: FloatArray, fit: Fit, extent: Extent) -> Iterator[str]:
    shares = (fit.near_share, fit.covered_share)
    if min(shares) < POOR_SHARE or max(shares) < POOR_BOTH:
        yield (
            f"the fit is poor: {fit.near_share:.0%} of the cloud lies near the model and {fit.covered_share:.0%} of "
            "the model near the cloud; look at the result before you use it"
        )
    if fit.mutual > GOOD_SHARE:
        return
    few = np.random.default_rng(0).permutation(len(scene))[:_FEW]
    here = fit_of(maps, placed[few]).mutual
    best, what = max((_registered(maps, changed).mutual, what) for what, changed in _changed(scene[few], extent))
    if best > here + CLEARLY:
        yield f"the cloud fits better when it is {what} ({best:.0%}, not {here:.0%}); check its axes and units"


def _changed(scene: FloatArray, extent: Extent) -> Iterator[tuple[str, FloatArray]]:
    """The cloud as it might have been meant, and what was done to it."""
    for axis, name in enumerate("xyz"):
        mirror = np.ones(3)
        mirror[axis] = -1
        yield f"mirrored along {name}", scene * mirror
    if not 1 / OTHER_SIZE < extent.size_ratio < OTHER_SIZE:
        yield f"made {1 / extent.size_ratio:.3g} times as large", (scene - scene.mean(axis=0)) / extent.size_ratio


def _registered(maps: Maps, scene: FloatArray) -> Fit:
    track = register(maps, scene, max_iterations=_ITERATIONS)
    return fit_of(maps, transform(track.T_model_scene[-1], scene))


def _of_extent(maps: Maps, extent: Extent) -> Iterator[str]:
    longest, middle, shortest = extent.spread
    if middle < FLAT * longest:
        yield "the points lie on a line; how the cloud is turned about it cannot be known"
    elif shortest < FLAT * longest:
        yield "the points lie in a plane; which side of it is up, and how it lies on the model, cannot be known"
    if extent.step > COARSE * maps.frame.scale:
        yield f"the coordinates are rounded to {extent.step:.3g}; write more digits, or smaller numbers, into the file"
    if extent.densest_share > DENSE:
        yield f"{extent.densest_share:.0%} of the points crowd in one place, so the rest hardly counts; thin it evenly"


def _of_model(maps: Maps) -> Iterator[str]:
    angle = symmetry(maps.histogram.model.points.astype(np.float64))
    if angle:
        yield f"the model looks the same when it is turned by {angle}°; which of these poses is right cannot be known"


def symmetry(model: FloatArray) -> int | None:
    """The smallest of a few angles after whose turn about an axis of the model, or of its frame, it looks the same.

    Points count as in the same place when they are no farther from each other than the model's are.
    """
    centred = model - model.mean(axis=0)
    axes = [*np.linalg.eigh(np.cov(centred.T))[1].T, *np.eye(3)]
    tree = KDTree(centred)
    near = max(NEAR, float(np.median(tree.query(centred, k=2)[0][:, 1])))
    for angle, axis in product((60, 72, 90, 120, 180), axes):
        turned = Rotation.from_rotvec(np.radians(angle) * axis).apply(centred)
        if (tree.query(turned)[0] <= near).mean() >= ALIKE:
            return angle
    return None
