"""Register a file onto the shipped bunny, in the file's own units: `python assets/examples/01_register_a_file.py`.

The same on the command line: `ido register scan.ply --maps improved.npz`.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import ido
from ido import poses
from ido.files import save_cloud
from ido.user_units import register_original


def made_up_scan(folder: Path) -> Path:
    """A file with a part of the bunny, in metres, turned by 40° about x and moved by 3 cm."""
    bunny = ido.shipped_cloud("bunny")
    scene = ido.perturb(bunny, ido.Perturbation(points=2000, noise=0.01, outliers=100, rotation=0, translation=0))
    T = poses.exp(np.array([0, 0.03, 0, np.deg2rad(40), 0, 0]))
    save_cloud(folder / "scan.ply", poses.transform(T, bunny.frame.to_user_units(scene.points)))
    return folder / "scan.ply"


with tempfile.TemporaryDirectory() as folder:
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else made_up_scan(Path(folder))
    scan = ido.load_cloud(file)

maps = ido.shipped_maps("bunny", "triple-binary")  # Improved DO; or ido.Maps.load("improved.npz")
T_model_scan, trajectory = register_original(maps, scan)

np.set_printoptions(precision=4, suppress=True)
print(f"{len(scan)} points: {trajectory.stop} after {trajectory.iterations} iterations")
print("pose that moves the scan onto the model, in the scan's units:")
print(T_model_scan)
angle = np.rad2deg(np.linalg.norm(poses.log(T_model_scan)[3:]))
print(f"it turns by {angle:.1f}°")
