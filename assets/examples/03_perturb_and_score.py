"""Perturb the bunny, register it, and score that: `python assets/examples/03_perturb_and_score.py`.

A perturbation is a value: the same seed and numbers give the same scene on every machine.
"""

import ido

bunny = ido.shipped_cloud("bunny")
scene = ido.perturb(bunny, ido.Perturbation(rotation=75, translation=0.3, noise=0.05, outliers=300, seed=11))
print(f"{len(scene.points)} points, {scene.is_outlier.sum()} of them outliers")

for name in ("DO", "Improved DO", "Improved DO (near / far)", "GMMReg, tuned", "ICP, tuned", "Did nothing"):
    trajectory = ido.shipped_method("bunny", name).register(scene.points)
    scores = ido.score(scene, trajectory.T_model_scene)  # of every pose on the way
    print(
        f"{name:25} PointAcc {scores.accuracy[-1]:.2f}, turned {scores.rotation[0]:.0f}° -> {scores.rotation[-1]:.1f}°"
        f", {trajectory.iterations} iterations, {trajectory.stop}"
    )
