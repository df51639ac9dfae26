"""Train maps on a cloud, save them, and see how far they reach: `python assets/examples/02_train_on_a_cloud.py`.

It trains on few scenes, to be done in seconds. `ido train` takes 30,000 scenes and 30 maps, as the paper does.
"""

import sys
import tempfile
from pathlib import Path

import ido
from ido.experiments import LEVELS, sweep

cloud = ido.Cloud.of(ido.load_cloud(sys.argv[1])) if len(sys.argv) > 1 else ido.shipped_cloud("bunny")
model = ido.Model.of(cloud, n_points=150)


def progress(done: int, error: float) -> None:
    """Called before the first map, and after each."""
    print(f"training error after {done} maps: {error:.4f}")


maps = ido.train(cloud, ido.FrontBack(model), ido.TrainingSettings(samples=1000, maps=6), progress=progress)

with tempfile.TemporaryDirectory() as folder:
    maps.save(Path(folder) / "mine.npz")
    maps = ido.Maps.load(Path(folder) / "mine.npz")

accuracy = sweep(cloud, maps, "rotation", scenes=10)[..., 0].mean(axis=1)
for level, mean in zip(LEVELS["rotation"], accuracy, strict=True):
    print(f"turned by {level:3.0f}°: PointAcc {mean:.2f}")
