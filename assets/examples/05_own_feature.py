"""A feature of one's own, twice, and maps trained on it: `python assets/examples/05_own_feature.py`.

As a histogram, it says what the bins are. As a question, it says what a model point asks of a scene point; then it has
a diagram and can be inspected pair by pair, too. Both give the same bins here.

In the explorer: `ido-viz --histogram assets/examples/05_own_feature.py:InsideOutsideAsked`.
"""

import numpy as np
import trimesh

import ido
from ido.types import BoolArray, DoubleArray, FloatArray

REACH = 0.3
"""Scene points farther from a model point do not count for it (model units)."""


class InsideOutside(ido.Histogram):
    """How many scene points near each model point are closer to the origin than it, and how many are not."""

    name = "inside-outside"
    blocks = (ido.Block("inside", "outside"),)

    def describe(self, moved: FloatArray) -> FloatArray:
        """The histogram of points (S, 3) in the model's frame: M bins inside, M bins outside."""
        model = self.model.points
        near = np.linalg.norm(moved[None] - model[:, None], axis=2) < REACH
        inside = np.linalg.norm(moved, axis=1)[None] < np.linalg.norm(model, axis=1)[:, None]
        counts = np.concatenate([(near & inside).sum(axis=1), (near & ~inside).sum(axis=1)])
        return counts / max(np.linalg.norm(counts), 1.0)


class InsideOrOutside(ido.Question):
    """Inside when ‖s‖ < ‖m_a‖; a point within 0.3 of m_a counts 1, others nothing."""

    def __init__(self) -> None:
        super().__init__("inside", "outside", color=(213, 94, 0))

    def answers(self, points: FloatArray, normals: FloatArray, moved: FloatArray) -> BoolArray:
        return np.linalg.norm(moved, axis=1)[None] < np.linalg.norm(points, axis=1)[:, None]

    def weights(self, points: FloatArray, moved: FloatArray) -> DoubleArray:
        return (np.linalg.norm(moved[None] - points[:, None], axis=2) < REACH).astype(np.float64)

    def surface(self, point: FloatArray, normal: FloatArray) -> ido.Surface:
        """The sphere around the origin that goes through the model point."""
        sphere = trimesh.creation.icosphere(subdivisions=3, radius=float(np.linalg.norm(point)))
        return ido.Surface(np.asarray(sphere.vertices), np.asarray(sphere.faces))


class InsideOutsideAsked(ido.BlockHistogram):
    """The same feature as a question; its block could stand beside others: ``(*ido.FrontBack.blocks, ...)``."""

    name = "inside-outside-asked"
    blocks = (InsideOrOutside(),)


if __name__ == "__main__":
    bunny = ido.shipped_cloud("bunny")
    model = ido.Model.of(bunny, n_points=60)
    scene = ido.perturb(bunny, ido.Perturbation(rotation=30))
    said, asked = (feature(model)(scene.points, np.zeros(6)) for feature in (InsideOutside, InsideOutsideAsked))
    print("both give the same bins:", np.allclose(said, asked, atol=1e-6))

    maps = ido.train(bunny, InsideOutsideAsked(model), ido.TrainingSettings(samples=300, maps=4))
    print("training error after each map:", np.round(maps.curves.mean, 3))
    trajectory = ido.register(maps, scene.points)
    scores = ido.score(scene, trajectory.T_model_scene)
    print(f"rotation error {scores.rotation[0]:.0f}° -> {scores.rotation[-1]:.0f}°")
