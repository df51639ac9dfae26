"""A method of one's own: `python assets/examples/04_own_method.py`.

In the explorer: `ido-viz --method assets/examples/04_own_method.py:PointToPlane`.
"""

import numpy as np
from scipy.spatial import KDTree

import ido
from ido import poses
from ido.types import FloatArray


class PointToPlane:
    """Moves every scene point half way to the plane of the nearest model point; far ones count less."""

    name = "Point to plane"

    def __init__(self, cloud: ido.Cloud) -> None:
        self.model = ido.Model.of(cloud)
        self.tree = KDTree(self.model.points)

    def update(self, points: FloatArray, x: FloatArray) -> FloatArray:
        """How the pose x (6,) of a scene (S, 3) is to change; shape (6,)."""
        T = poses.exp(x)  # where the scene is now
        moved = poses.transform(T, points)
        distance, nearest = self.tree.query(moved)
        weight = np.exp(-((distance / 0.3) ** 2))
        normals = self.model.normals[nearest]
        away = ((self.model.points[nearest] - moved) * normals).sum(axis=1)
        rows = np.hstack([normals, np.cross(moved, normals)])
        step = np.linalg.lstsq(weight[:, None] * rows, weight * away)[0]
        return poses.log(poses.exp(0.5 * step) @ T) - x


if __name__ == "__main__":
    bunny = ido.shipped_cloud("bunny")
    mine = PointToPlane(bunny)
    for rotation in (10, 20, 40, 80):
        scene = ido.perturb(bunny, ido.Perturbation(rotation=rotation))
        trajectory = ido.register_updates(mine, scene.points)
        accuracy = ido.score(scene, trajectory.T_model_scene[-1]).accuracy
        print(f"{rotation}°: {trajectory.stop} after {trajectory.iterations} iterations, PointAcc {accuracy:.2f}")
