"""The global method: search, climb, refine and choose, with all that was tried (docs/global.md, "In steps")."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from ido import poses
from ido.global_registration.climbing import Climb, climb
from ido.global_registration.cut_plane import Posterior, odds_of, refine
from ido.global_registration.fields import SIGMAS, Field
from ido.global_registration.global_result import Branch, Candidate, GlobalResult, Stage
from ido.global_registration.model import GlobalModel
from ido.global_registration.outliers import Background
from ido.global_registration.planes import NO_PLANE
from ido.global_registration.settings import GlobalSettings
from ido.global_registration.spread import Spread, moved_by, newton_step
from ido.histograms import finite
from ido.registration import Trajectory, Watch
from ido.types import DoubleArray, FloatArray, IntArray

STARTS = 360
"""Poses of the search that are climbed from, with and without a ball together."""

LEAST_POINTS = 10
"""A scene has at least so many points."""

MOST_POINTS = 20_000
"""Of a larger scene a random subset of so many is searched with, always the same one."""

_FIRST = ((-1, 5, 200, 160), (-2, 8, 256, 64), (-2, 8, 384, 7))  # field, steps, points, and how many starts go on
_LAST_FEW = 20  # where fewer starts than that go on, no two of them are alike
_LAST_STEPS, _LAST_POINTS = 10, 1200
_REFINED = 4
_SHORTENED = 4  # times that a step is tried before there is none
_TURNS, _CLOSE = 2, 0.05  # plane and pose by turns, of those that are so near to the best (log-likelihood per point)
_ALIKE = (10.0, 0.12)  # poses nearer to each other than so many degrees and model units are one


class Starts(Protocol):
    """Gives poses to climb from."""

    def __call__(
        self, points: FloatArray, backgrounds: Sequence[Background], /
    ) -> list[tuple[DoubleArray, FloatArray]]:
        """For each background of points (S, 3) near the origin: poses (n, 4, 4) and their scores (n,)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class GlobalRegistration:
    """Registers from any start.

    Args:
        model: what scenes are registered onto.
        settings: what is assumed of them.
        starts: gives the poses to climb from; the model's search unless given.
    """

    model: GlobalModel
    settings: GlobalSettings = field(default_factory=GlobalSettings)
    starts: Starts | None = None

    def register(self, points: FloatArray, *, watch: Watch | None = None) -> Trajectory:
        """Register one scene, points (S, 3) in model units; `run` has all that was tried.

        Raises:
            ValueError: coordinates are not finite, there are fewer than 10 points, or all lie in one place.
        """
        return self.run(points, watch=watch).trajectory

    def run(self, points: FloatArray, *, watch: Watch | None = None) -> GlobalResult:
        """Register one scene, points (S, 3) in model units, wherever it lies.

        Args:
            points: the scene.
            watch: called after each stage with the number of steps so far; what it raises ends the registration.

        Raises:
            ValueError: coordinates are not finite, there are fewer than 10 points, or all lie in one place.
        """
        whole = checked(points)
        points = whole
        if len(whole) > MOST_POINTS:
            points = np.random.default_rng(0).choice(whole, MOST_POINTS, replace=False)
        middle = np.median(points, axis=0)
        centring = np.eye(4)
        centring[:3, 3] = -middle
        centred = points - middle
        found = Background.of(centred, self.settings)
        backgrounds = [found, found.without_ball] if found.has_ball else [found]
        order = np.random.default_rng(0).permutation(len(points))
        branches, steps = [], 0
        count = STARTS // len(backgrounds)
        for background, (T, scores) in zip(
            backgrounds, (self.starts or self.model.search)(centred, backgrounds), strict=True
        ):
            best = np.argsort(-scores, kind="stable")[:count]
            T, scores = T[best], scores[best]
            stages = []
            for stage in self._climbed(centred, background, T, order):
                stages.append(stage)
                steps += stage.climb.steps
                if watch:
                    watch(steps)
            branches.append(Branch(background, scores, tuple(stages)))
        few = order[:_LAST_POINTS]
        candidates = self._refined(centred, few, branches)
        first = candidates[0]
        spread = Spread.of(first.posterior, first.refined)
        motion = spread.motion if len(whole) <= _LAST_POINTS else self._of_all(first, spread, whole - middle)
        T = moved_by(motion, first.refined.T)
        return GlobalResult(centring, tuple(branches), candidates, spread.covariance, T, len(points))

    def _climbed(self, points: FloatArray, background: Background, T: DoubleArray, order: IntArray) -> Iterator[Stage]:
        """First on few points, with fewer and fewer starts; then on more, from wide to narrow, all that are left."""
        # what is in the ball says nothing of the pose, so the few points are others
        telling = order[np.argsort(background.in_ball[order] > 0.5, kind="stable")]
        for i, steps, n_points, kept in _FIRST:
            few = telling[:n_points]
            part, field = background.part(few), self.model.fields[i]
            tried = climb(points[few], part, field, T, steps)
            heights, last = tried.log_likelihood[:, -1], kept < _LAST_FEW
            if last and self.settings.cut_plane:
                heights = heights + self._raised(points[few], part, field, tried)
            best = np.argsort(-heights, kind="stable")
            best = _distinct(tried.poses[:, -1], best, kept) if last else best[:kept]
            T = tried.poses[best, -1]
            yield Stage(tried, best)
        few = order[:_LAST_POINTS]
        yield from _narrowing(points[few], background.part(few), self.model, T)

    def _raised(self, points: FloatArray, background: Background, field: Field, tried: Climb) -> DoubleArray:
        """By how much a plane raises the log-likelihood per point of each start where it is, shape (n,).

        Where much is missing, the climb, which knows no plane, is higher elsewhere.
        """
        moved = poses.transform(tried.poses[:, -1], points).astype(np.float32)
        odds = odds_of(background, field, tried.shares, moved)
        return self.model.few_planes.gains(moved, odds) / len(points)

    @property
    def _ball_free(self) -> GlobalSettings:
        return replace(self.settings, ball=False)

    def _of_all(self, best: Candidate, spread: Spread, points: FloatArray) -> DoubleArray:
        """The motion from a top to the mean pose of all points (S, 3), centred, of which it was found with a part.

        To their top it is a Newton step, shortened until it leads uphill; from there to their mean it is shorter, the
        more points there are.
        """
        top, few = best.refined, best.posterior
        background = Background.of(points, self.settings if few.background.has_ball else self._ball_free)
        everything = replace(few, points=points, background=background)
        before, gradient = everything(top.T, top.normal, top.offset)
        step = newton_step(few, top, few.n_different * gradient[:6])
        for _ in range(_SHORTENED):
            if everything(moved_by(step, top.T), top.normal, top.offset)[0] > before:
                break
            step = step / 2
        else:
            step = np.zeros(6)
        return step + spread.motion * len(few.points) / len(points)

    def _refined(self, points: FloatArray, few: IntArray, branches: list[Branch]) -> tuple[Candidate, ...]:
        """The likeliest poses of all branches, refined; alike ones are dropped."""
        cut = self.settings.cut_plane
        tried: list[tuple[float, Posterior, DoubleArray, tuple[int, int, int]]] = []
        for number, branch in enumerate(branches):
            part = branch.background.part(few)
            for start, (likelihood, posterior, T, stage) in enumerate(
                _summits(points[few], part, self.model, branch.stages[-len(SIGMAS) :], cut=cut)
            ):
                at = len(branch.stages) - len(SIGMAS) + stage
                tried.append((likelihood, posterior, T, (number, start, at)))
        tried.sort(key=lambda one: -one[0])
        apart = _distinct(np.stack([T for _, _, T, _ in tried]), np.arange(len(tried)), _REFINED)
        found = [Candidate(refine(tried[i][1], tried[i][2], cut=cut), tried[i][1], *tried[i][3]) for i in apart]
        for _ in range(_TURNS if cut else 0):
            highest = max(candidate.refined.log_likelihood for candidate in found)
            found = [
                candidate.again() if candidate.refined.log_likelihood > highest - _CLOSE else candidate
                for candidate in found
            ]
        found.sort(key=lambda candidate: -candidate.refined.log_likelihood)
        apart = _distinct(np.stack([candidate.refined.T for candidate in found]), np.arange(len(found)), _REFINED)
        return tuple(found[i] for i in apart)


def polish(
    model: GlobalModel, points: FloatArray, T_model_scene: FloatArray, settings: GlobalSettings | None = None
) -> DoubleArray:
    """The last part of the global method, from the pose of any other: uphill on narrowing fields, and refined.

    Args:
        model: what the scene was registered onto.
        points: the scene, shape (S, 3), model units.
        T_model_scene: the pose to begin with, shape (4, 4).
        settings: what is assumed of the scene.

    Returns:
        the mean pose about the top of the likelihood near it, shape (4, 4).

    Raises:
        ValueError: coordinates are not finite, there are fewer than 10 points, or all lie in one place.
    """
    settings = settings or GlobalSettings()
    points = checked(points)
    few = np.random.default_rng(0).permutation(len(points))[:_LAST_POINTS]
    points = points[few]
    background = Background.of(points, settings)
    stages = tuple(_narrowing(points, background, model, np.asarray(T_model_scene, dtype=np.float64)[None]))
    ((_, posterior, T, _),) = _summits(points, background, model, stages, cut=settings.cut_plane)
    top = refine(posterior, T, cut=settings.cut_plane)
    return moved_by(Spread.of(posterior, top).motion, top.T)


def checked(points: FloatArray) -> FloatArray:
    """Points as they can be registered, float32.

    Raises:
        ValueError: coordinates are not finite, there are fewer than 10 points, or all lie in one place.
    """
    points = finite(points)
    if len(points) < LEAST_POINTS:
        raise ValueError(f"a scene needs at least {LEAST_POINTS} points; this has {len(points)}")
    if not np.ptp(points, axis=0).any():
        raise ValueError("all points of the scene lie in one place; check its file and columns")
    return points


def _narrowing(points: FloatArray, background: Background, model: GlobalModel, T: DoubleArray) -> Iterator[Stage]:
    """Climb from poses T (n, 4, 4) on every field, the widest first."""
    for width in reversed(model.fields):
        tried = climb(points, background, width, T, _LAST_STEPS)
        T = tried.poses[:, -1]
        yield Stage(tried, np.arange(len(T)))


def _summits(
    points: FloatArray, background: Background, model: GlobalModel, stages: Sequence[Stage], *, cut: bool
) -> Iterator[tuple[float, Posterior, DoubleArray, int]]:
    """For each start of the last stages: its likelihood with a first plane, on the field that fits it best; what it is
    the likelihood of; its pose there; and the number of that stage."""
    best = np.argmax([stage.climb.log_likelihood[:, -1] for stage in stages], axis=0)
    for start, number in enumerate(best):
        reached = stages[number].climb
        posterior = Posterior(points, background, model.fields[-1 - number], model.planes, reached.shares[start])
        T = reached.poses[start, -1]
        plane = posterior.first_plane(T) if cut else NO_PLANE
        yield posterior(T, *plane)[0], posterior, T, int(number)


def _distinct(T: DoubleArray, order: IntArray, count: int) -> IntArray:
    """The first `count` of poses T (n, 4, 4) in an order, without those that are like one before; numbers of them."""
    found: list[int] = []
    for i in order:
        cosine = (np.einsum("nij,ij->n", T[found, :3, :3], T[i, :3, :3]) - 1) / 2
        shift = np.linalg.norm(T[found, :3, 3] - T[i, :3, 3], axis=1)
        if not ((cosine > np.cos(np.radians(_ALIKE[0]))) & (shift < _ALIKE[1])).any():
            found.append(int(i))
        if len(found) == count:
            break
    return np.array(found)
