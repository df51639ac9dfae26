"""The global method: search, climb, refine, and choose; with all that was tried (docs/global.md, "Global")."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ido import poses
from ido.global_registration.background import Background
from ido.global_registration.climbing import Climb, climb
from ido.global_registration.cut_plane import Refined, refine
from ido.global_registration.fields import SIGMAS, Field
from ido.global_registration.search import Search
from ido.global_registration.settings import GlobalSettings
from ido.histograms import finite
from ido.registration import StopReason, Trajectory, Watch
from ido.types import DoubleArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class Rung:
    """A part of the climb: on which field, how many steps, on how many points, and how many starts go on."""

    sigma: float
    steps: int
    points: int
    kept: int


LADDER = (Rung(0.1, 5, 256, 120), Rung(0.065, 8, 256, 30), Rung(0.045, 8, 384, 8))
STARTS = 240
LAST_STEPS = 15
LAST_POINTS = 1500
REFINED = 3
APART = (10.0, 0.12)
"""Poses that differ by less than so many degrees and model units are one candidate."""


@dataclass(frozen=True, slots=True, eq=False)
class GlobalModel:
    """What scenes are registered onto: fields and search of one cloud, made once."""

    fields: tuple[Field, ...]
    search: Search
    points: FloatArray

    @classmethod
    def of(cls, points: FloatArray, settings: GlobalSettings) -> GlobalModel:
        fields = tuple(Field.of(points, sigma) for sigma in SIGMAS)
        few = np.random.default_rng(0).choice(len(points), min(len(points), 600), replace=False)
        return cls(fields, Search.of(fields[-1], settings.rotations), points[few])

    def field(self, sigma: float) -> Field:
        return self.fields[SIGMAS.index(sigma)]


@dataclass(frozen=True, slots=True, eq=False)
class GlobalResult:
    stages: tuple[Climb, ...]
    kept: tuple[IntArray, ...]
    candidates: tuple[Refined, ...]
    background: Background
    trajectory: Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class GlobalRegistration:
    model: GlobalModel
    settings: GlobalSettings = field(default_factory=GlobalSettings)

    def run(self, points: FloatArray, watch: Watch | None = None) -> GlobalResult:
        points = finite(points)
        middle = np.median(points, axis=0)
        centred = points - middle
        background = Background.of(centred, self.settings)
        T, scores = self.model.search(centred, background)
        chosen = np.argsort(-scores, kind="stable")[:STARTS]
        rng = np.random.default_rng(0)
        order = rng.permutation(len(points))
        order = order[np.argsort(background.in_ball[order] > 0.5, kind="stable")]
        T = T[chosen]
        stages, kept = [], [chosen]
        for rung in LADDER:
            few = order[: rung.points]
            stage = climb(centred[few], background.part(few), self.model.field(rung.sigma), T, rung.steps)
            best = np.argsort(-stage.log_likelihood[:, -1], kind="stable")
            best = best[: rung.kept] if rung is not LADDER[-1] else distinct(stage.poses[best, -1], best, rung.kept)
            T = stage.poses[best, -1]
            stages.append(stage)
            kept.append(best)
        few = order[:LAST_POINTS]
        last, part = centred[few], background.part(few)
        finals = []
        for fld in reversed(self.model.fields):
            stage = climb(last, part, fld, T, LAST_STEPS)
            T = stage.poses[:, -1]
            stages.append(stage)
            finals.append(stage)
        likelihood = np.stack([stage.log_likelihood[:, -1] for stage in finals])
        width = likelihood.argmax(axis=0)
        order = np.argsort(-likelihood.max(axis=0), kind="stable")[:REFINED]
        candidates = [
            refine(
                last,
                part,
                self.model.field(finals[width[i]].sigma),
                self.model.points,
                finals[width[i]].poses[i, -1],
                finals[width[i]].shares[i],
                cut=self.settings.cut_plane,
            )
            for i in order
        ]
        candidates.sort(key=lambda c: -c.log_likelihood)
        back = np.eye(4)
        back[:3, 3] = -middle
        T = np.stack([np.eye(4), candidates[0].T @ back])
        track = Trajectory(poses.log(T), np.zeros(1), StopReason.CONVERGED, np.nan)
        return GlobalResult(tuple(stages), tuple(kept), tuple(candidates), background, track)


def distinct(T: DoubleArray, order: IntArray, count: int) -> IntArray:
    found: list[int] = []
    for i in range(len(T)):
        R = T[i, :3, :3]
        for j in found:
            cosine = (np.trace(R.T @ T[j, :3, :3]) - 1) / 2
            if cosine > np.cos(np.radians(APART[0])) and np.linalg.norm(T[i, :3, 3] - T[j, :3, 3]) < APART[1]:
                break
        else:
            found.append(i)
            if len(found) == count:
                break
    return order[np.array(found)]
