"""Registering a cloud that is given in the user's own units, from where it lies or from the model's centre."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.spatial import KDTree

from ido.clouds import Cloud, CloudError
from ido.maps import Maps
from ido.perturbation import OUTLIER_REACH
from ido.poses import transform
from ido.registration import EPSILON, MAX_ITERATIONS, Trajectory, register
from ido.types import FloatArray

REGISTERED_POINTS = 4000
"""A denser cloud is registered by a random subset of this many points, as many as the paper's largest scenes have."""

SEEN_WITHIN = 0.6
"""Distance from the model beyond which a point's weight in the front / back block is below 1e-5 (model units)."""

Start = Literal["here", "centre"]
"""Where a registration starts: where the cloud lies, or with its bounding-box centre moved onto the model's."""


def register_original(
    maps: Maps,
    original: FloatArray,
    *,
    start: Start = "here",
    epsilon: float = EPSILON,
    max_iterations: int = MAX_ITERATIONS,
) -> tuple[FloatArray, Trajectory]:
    """Register a cloud, points (N, 3) in the user's units: of the cloud that the maps were trained on.

    Returns:
        T_model_scene (4, 4) in the user's units, start included, and the trajectory, in model units from the start.
    """
    scene, T_start = scene_at_start(maps, original, start)
    track = register(maps, scene, epsilon=epsilon, max_iterations=max_iterations)
    return maps.frame.pose_in_user_units(track.T_model_scene[-1] @ T_start), track


def scene_at_start(maps: Maps, original: FloatArray, start: Start) -> tuple[FloatArray, FloatArray]:
    """What is registered, shape (S, 3) in model units, and the pose (4, 4) that brought it there from where it lay."""
    scene = maps.frame.to_model_units(registered_points(original))
    T_start = np.eye(4)
    if start == "centre":
        T_start[:3, 3] = -(scene.min(axis=0) + scene.max(axis=0)) / 2
    return transform(T_start, scene), T_start


def registered_points(points: FloatArray) -> FloatArray:
    """The points (N, 3) that are registered: all, or a random subset of `REGISTERED_POINTS`, always the same."""
    if len(points) <= REGISTERED_POINTS:
        return points
    return np.random.default_rng(0).choice(points, REGISTERED_POINTS, replace=False)


def doubts(maps: Maps, original: FloatArray, start: Start) -> list[str]:
    """Why maps may fail on a cloud, points (N, 3) in the user's units; empty when nothing is odd."""
    scene, _ = scene_at_start(maps, original, start)
    model = maps.histogram.model.points
    found = []
    size = float(np.ptp(scene, axis=0).max() / np.ptp(model, axis=0).max())
    if size > 5 or size < 0.1:
        found.append(
            f"the cloud is {size:.3g} times as large as the model; "
            "is it in the units of the cloud that the maps were trained on?"
        )
    share = float((np.abs(scene) <= OUTLIER_REACH).all(axis=1).mean())
    nearest = float(KDTree(model).query(scene)[0].min())
    if share < 0.1 or nearest > SEEN_WITHIN:
        reach = OUTLIER_REACH * maps.frame.scale
        found.append(
            f"{share:.0%} of the points lie within the maps' reach, ±{reach:.3g} in your units around the model's "
            f"centre, so the maps see {'nothing' if nearest > SEEN_WITHIN else 'little'} of the cloud"
        )
        if start == "here":
            found.append("try --start centre, or move the cloud closer, and check its units")
    return found


def cloud_of_maps(maps: Maps, original: FloatArray) -> Cloud:
    """The cloud that maps were trained on, points (N, 3) in the user's units, in the maps' own frame.

    Raises:
        CloudError: its bounding box does not fit.
    """
    points = maps.frame.to_model_units(original).astype(np.float32)
    reach = np.abs([points.min(axis=0), points.max(axis=0)])
    if not (np.allclose(reach[0], reach[1], atol=0.05) and np.isclose(reach.max(), 1, atol=0.05)):
        raise CloudError("the maps were trained on a cloud of another size or in another place")
    return Cloud(points, maps.frame)
