"""Calibrate how sure a global registration is: `python assets/scripts/make_confidence.py` writes confidence.toml.

Scenes of random shapes, most of them hard, some of another shape or of none, are registered; a logistic regression then
tells from the evidence which poses are right. It is tested on families of shapes that it never saw, and on the shipped
shapes. Takes about a quarter of an hour on one core.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y

from ido import Cloud, GlobalModel, GlobalRegistration, Perturbation, perturb, score, shipped_cloud
from ido.disk import write_whole
from ido.experiments.reliability import DOUBTED, RIGHT, SURE, Reliability
from ido.global_registration import Evidence
from ido.global_registration.confidence import features, probability
from ido.types import DoubleArray, FloatArray

SHAPES_A_FAMILY, SCENES = 12, 24
POINTS = 20_000
SEED = 40_000_000
RIDGE = 1.0

Make = Callable[[np.random.Generator], DoubleArray]


def primitives(rng: np.random.Generator) -> DoubleArray:
    """Boxes, cylinders, cones and balls, overlapping at random."""
    parts = []
    for _ in range(rng.integers(3, 7)):
        size = rng.uniform(0.2, 0.8, 3)
        kind = rng.integers(4)
        part = (
            trimesh.creation.box(size),
            trimesh.creation.cylinder(size[0] / 2, size[1]),
            trimesh.creation.cone(size[0] / 2, size[1]),
            trimesh.creation.icosphere(3, size[0] / 2),
        )[kind]
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = Rotation.random(rng=rng).as_matrix(), rng.uniform(-0.6, 0.6, 3)
        parts.append(part.apply_transform(T))
    return sampled(trimesh.util.concatenate(parts), rng)


def symmetric(rng: np.random.Generator) -> DoubleArray:
    """A single primitive, which looks the same from several sides."""
    a, b, c = rng.uniform(0.3, 1, 3)
    mesh = (
        trimesh.creation.box((a, b, c)),
        trimesh.creation.cylinder(a, b),
        trimesh.creation.torus(1, 0.4 * a),
        trimesh.creation.capsule(b, a),
    )[rng.integers(4)]
    return sampled(mesh, rng)


def terrain(rng: np.random.Generator) -> DoubleArray:
    """A square of ground with hills and steps."""
    xy = rng.uniform(-1, 1, (POINTS, 2))
    height = np.zeros(POINTS)
    for _ in range(12):
        away = np.linalg.norm(xy - rng.uniform(-1, 1, 2), axis=1) / rng.uniform(0.1, 0.5)
        height += rng.normal(0, 0.25) * (np.exp(-(away**2)) if rng.random() < 0.6 else away < 1)
    return np.column_stack([xy, height])


def blob(rng: np.random.Generator) -> DoubleArray:
    """A lump whose radius is a sum of spherical harmonics."""
    way = rng.standard_normal((POINTS, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    polar, around = np.arccos(way[:, 2]), np.arctan2(way[:, 1], way[:, 0])
    radius = np.ones(POINTS)
    for degree in range(1, 6):
        for order in range(-degree, degree + 1):
            radius += rng.normal(0, 0.35 / degree) * sph_harm_y(degree, abs(order), polar, around).real
    return way * np.maximum(radius, 0.2)[:, None]


def tube(rng: np.random.Generator) -> DoubleArray:
    """A tube along a closed random curve."""
    t = rng.uniform(0, 2 * np.pi, POINTS)
    waves = rng.normal(0, 1, (3, 2, 3)) / np.arange(1, 4)[:, None, None]
    curve = sum(
        waves[k, 0] * np.cos((k + 1) * t)[:, None] + waves[k, 1] * np.sin((k + 1) * t)[:, None] for k in range(3)
    )
    way = rng.standard_normal((POINTS, 3))
    return curve + rng.uniform(0.1, 0.3) * way / np.linalg.norm(way, axis=1)[:, None]


def knot(rng: np.random.Generator) -> DoubleArray:
    """A torus knot."""
    p, q = ((2, 3), (3, 2), (2, 5), (3, 4))[rng.integers(4)]
    t = rng.uniform(0, 2 * np.pi, POINTS)
    radius = 1 + rng.uniform(0.2, 0.5) * np.cos(q * t)
    curve = np.column_stack([radius * np.cos(p * t), radius * np.sin(p * t), 0.5 * np.sin(q * t)])
    curve[:, 0] *= rng.uniform(0.6, 1)
    way = rng.standard_normal((POINTS, 3))
    return curve + 0.15 * way / np.linalg.norm(way, axis=1)[:, None]


def furniture(rng: np.random.Generator) -> DoubleArray:
    """Upright boxes that stand on and beside each other, as a table with things on it."""
    top = rng.uniform(0.4, 1)
    boxes = [((2 * top, rng.uniform(0.6, 1.4), 0.08), (0, 0, 0.5))]
    boxes += [((0.1, 0.1, 1), (x * top * 0.9, y * 0.3, 0)) for x in (-1, 1) for y in (-1, 1) if rng.random() < 0.85]
    for _ in range(rng.integers(1, 5)):
        size = rng.uniform(0.1, 0.5, 3)
        boxes.append((tuple(size), (rng.uniform(-top, top), rng.uniform(-0.3, 0.3), 0.54 + size[2] / 2)))
    meshes = [trimesh.creation.box(size).apply_translation(place) for size, place in boxes]
    return sampled(trimesh.util.concatenate(meshes), rng)


def vase(rng: np.random.Generator) -> DoubleArray:
    """A surface of revolution with a handle: nearly symmetric."""
    height, around = rng.uniform(-1, 1, POINTS), rng.uniform(0, 2 * np.pi, POINTS)
    radius = 0.5 + sum(rng.normal(0, 0.12) * np.cos(k * np.pi * height + rng.uniform(0, 6)) for k in range(1, 4))
    body = np.column_stack([radius * np.cos(around), radius * np.sin(around), height])
    n = POINTS // 12
    t, way = rng.uniform(0, np.pi, n), rng.standard_normal((n, 3))
    handle = np.column_stack([0.5 + 0.4 * np.sin(t), np.zeros(n), rng.uniform(0.3, 0.6) * np.cos(t)])
    handle += 0.06 * way / np.linalg.norm(way, axis=1)[:, None]
    return np.concatenate([body, handle])


LEARNED_FROM: tuple[Make, ...] = (primitives, symmetric, terrain, blob, tube)
TESTED_ON: tuple[Make, ...] = (knot, furniture, vase)


def sampled(mesh: trimesh.Geometry, rng: np.random.Generator) -> DoubleArray:
    assert isinstance(mesh, trimesh.Trimesh)
    return np.asarray(trimesh.sample.sample_surface(mesh, POINTS, seed=int(rng.integers(2**31)))[0])


def clouds(families: tuple[Make, ...], seed: int) -> Iterator[tuple[str, Cloud]]:
    for make in families:
        for number in range(SHAPES_A_FAMILY):
            yield make.__name__, Cloud.of(make(np.random.default_rng([seed, number])))


def perturbation(rng: np.random.Generator, seed: int) -> Perturbation:
    """A scene of any hardness: half of them as hard as the paper's sweeps at most."""
    hard = rng.random() < 0.5
    return Perturbation(
        noise=rng.uniform(0, 0.2 if hard else 0.1),
        points=int(100 * 10 ** rng.uniform(0, 1.2)),
        outliers=int(rng.uniform(0, 1000 if hard else 600)),
        incomplete=rng.uniform(0.5 if hard else 0, 0.9 if hard else 0.7),
        rotation=180.0 * rng.random(),
        translation=rng.random(),
        outlier_kind=("uniform", "structured")[rng.integers(2)],
        seed=seed,
    )


def nothing(rng: np.random.Generator) -> FloatArray:
    """A scene in which the model is not: a plane, a ball's surface, a line, or scattered points."""
    n = int(rng.integers(100, 1500))
    way = rng.standard_normal((n, 3))
    points = (
        rng.uniform(-1, 1, (n, 3)) * [1, 1, 0],
        rng.uniform(0.4, 1) * way / np.linalg.norm(way, axis=1)[:, None],
        rng.uniform(-1, 1, (n, 3)) * [1, 0, 0],
        rng.uniform(-1.5, 1.5, (n, 3)),
    )[rng.integers(4)]
    return points + rng.uniform(0.005, 0.05) * rng.standard_normal((n, 3))


def examples(shapes: list[tuple[str, Cloud]], seed: int) -> tuple[list[Evidence], np.ndarray]:
    """The evidence of many registrations, and which of them are right; a sixth is of another shape or of none."""
    values, right = [], []
    for number, (name, cloud) in enumerate(shapes):
        registration = GlobalRegistration(GlobalModel.of(cloud.points))
        rng = np.random.default_rng([seed, number])
        for trial in range(SCENES):
            its = perturbation(rng, seed + 1000 * number + trial)
            strange = trial % 12
            if strange == 0:
                points, found = nothing(rng), None
            else:
                other = shapes[(number + SHAPES_A_FAMILY) % len(shapes)][1]
                found = perturb(other if strange == 1 else cloud, replace(its, noise=0.02) if strange == 1 else its)
                points = found.points
            result = registration.run(points)
            is_right = strange > 1 and found is not None and score(found, result.T_model_scene).accuracy >= RIGHT
            values.append(result.evidence)
            right.append(is_right)
        print(f"{name}: {np.mean(right[-SCENES:]):.0%} right", file=sys.stderr, flush=True)
    return values, np.array(right)


def fitted(evidence: list[Evidence], right: np.ndarray) -> dict[str, float]:
    """The weights under which what was right is likeliest, with a small ridge on the standardised features.

    It is the whole probability that is fitted, with the weight of a pose among those that fit as well.
    """
    values = [features(one) for one in evidence]
    names = list(values[0])
    X = np.array([[value[name] for name in names] for value in values])
    among = np.array([one.weight for one in evidence])
    centre, spread = X.mean(axis=0), X.std(axis=0)
    Z = np.column_stack([np.ones(len(X)), (X - centre) / spread])

    def loss(w: DoubleArray) -> float:
        chance = np.clip(among / (1 + np.exp(-np.clip(Z @ w, -30, 30))), 1e-9, 1 - 1e-9)
        return float(-np.log(np.where(right, chance, 1 - chance)).sum() + RIDGE / 2 * (w[1:] ** 2).sum())

    w = minimize(loss, np.zeros(Z.shape[1])).x
    weights = dict(zip(names, (w[1:] / spread).tolist(), strict=True))
    return {"intercept": float(w[0] - (w[1:] * centre / spread).sum()), **weights}


def told(name: str, chance: DoubleArray, right: np.ndarray) -> str:
    """What a calibration is worth: expected calibration error, and how often sure answers and failures are told."""
    its = Reliability.of(chance, right)
    (sure, sure_right), (wrong, doubted) = its.sure, its.failures
    return (
        f"{name}: {its.total} scenes, {its.share_right:.3f} right, expected calibration error {its.error:.3f}; "
        f"p >= {SURE}: {sure_right / sure if sure else np.nan:.3f} right of {sure / its.total:.2f}; "
        f"failures below {DOUBTED}: {doubted / wrong if wrong else np.nan:.3f}"
    )


def main() -> None:
    values, right = examples(list(clouds(LEARNED_FROM, SEED)), SEED)
    weights = fitted(values, right)
    shipped = [(shape, shipped_cloud(shape)) for shape in ("bunny", "urban") for _ in range(SHAPES_A_FAMILY)]
    reports = []
    for name, (found, truth) in {
        "shapes learned from": (values, right),
        "unseen families": examples(list(clouds(TESTED_ON, SEED + 1)), SEED + 500_000),
        "bunny and urban": examples(shipped, SEED + 900_000),
    }.items():
        reports.append(told(name, np.array([probability(value, weights) for value in found]), truth))
    lines = [
        "# Made by assets/scripts/make_confidence.py: log-odds that a global registration is right, by its evidence.",
        *(f"# {report}" for report in reports),
        "",
        "[coefficients]",
        *(f"{name} = {weight:.4f}" for name, weight in weights.items()),
    ]
    write_whole(Path(__file__).parents[1] / "confidence.toml", ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
