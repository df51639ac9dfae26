"""Speed of the loops that matter, each beside a peer in the same run: `python tests/benchmarks/loops.py`.

Close other programs first: on a busy machine only the ratios mean something.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
import open3d as o3d
from rich.console import Console
from rich.table import Table

from ido import Perturbation, Scene, perturb, poses, register, score, shipped_cloud, shipped_maps
from ido.training import solve, training_scenes
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.core.state import State

SCENES = 60


def milliseconds(call: Callable[[], object], repeats: int) -> list[float]:
    """How long each of some calls takes, after one that does not count."""
    call()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - begin))
    return times


def histogram_rows(scenes: Sequence[Scene]) -> list[tuple[str, str, str, str]]:
    """Both histograms of a default scene at its start, compiled and in NumPy, one core."""
    rows = []
    points, x = scenes[0].points, np.zeros(6)
    moved = poses.transform(poses.exp(x), points.astype(np.float64))
    for name in ("front-back", "triple-binary"):
        histogram = shipped_maps("bunny", name).histogram
        numpy = float(np.median(milliseconds(lambda h=histogram: h.describe(moved), 15)))
        compiled = float(np.median(milliseconds(lambda h=histogram: h(points, x), 500)))
        exact = histogram.describe(moved)
        error = np.abs(histogram(points, x) - exact).max() / exact.max()
        text = f"NumPy {numpy:.1f} ms, relative error {error:.0e}"
        rows.append((f"{name} histogram, {len(points)} points", f"{compiled:.3f} ms", text, f"{numpy / compiled:.0f}×"))
    return rows


def registration_rows(scenes: Sequence[Scene]) -> list[tuple[str, str, str, str]]:
    """DO and Improved DO on default scenes, beside Open3D's point-to-point ICP."""
    model = shipped_maps("bunny", "front-back").histogram.model
    target = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(model.points.astype(np.float64)))
    criteria = o3d.pipelines.registration.ICPConvergenceCriteria(max_iteration=1000)

    def icp(scene: Scene) -> np.ndarray:
        source = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(scene.points.astype(np.float64)))
        result = o3d.pipelines.registration.registration_icp(source, target, 2.0, criteria=criteria)
        return np.asarray(result.transformation)

    def timed(method: Callable[[Scene], np.ndarray]) -> tuple[float, float]:
        times, accuracies = [], []
        for scene in scenes:
            begin = time.perf_counter()
            pose = method(scene)
            times.append(1e3 * (time.perf_counter() - begin))
            accuracies.append(float(score(scene, pose).accuracy))
        return float(np.median(times)), float(np.mean(accuracies))

    icp_time, icp_accuracy = timed(icp)
    rows = []
    for title, name in (("DO", "front-back"), ("Improved DO", "triple-binary")):
        maps = shipped_maps("bunny", name)
        mine, accuracy = timed(lambda scene, m=maps: register(m, scene.points).T_model_scene[-1])
        text = f"Open3D ICP {icp_time:.1f} ms, PointAcc {accuracy:.2f} against {icp_accuracy:.2f}"
        rows.append((f"{title} registration, median", f"{mine:.1f} ms", text, f"{icp_time / mine:.1f}×"))
    return rows


def frame_rows() -> list[tuple[str, str, str, str]]:
    """What a slider asks of the server: the scene, both registrations and all scores."""
    states = [State(perturbation=Perturbation(seed=seed)) for seed in range(30)]
    library = shipped_library()
    times = [milliseconds(lambda s=state: compute(s, library), 1)[0] for state in states]
    return [("run of a slider's frame, median and worst", f"{np.median(times):.0f}, {max(times):.0f} ms", "", "")]


def training_rows() -> list[tuple[str, str, str, str]]:
    """One map of a training at the paper's size, on all cores."""
    rows = []
    for name in ("front-back", "triple-binary"):
        maps = shipped_maps("bunny", name)
        scenes, x = training_scenes(shipped_cloud("bunny"), maps.settings)
        begin = time.perf_counter()
        h = maps.histogram.batch(scenes, np.zeros_like(x))
        middle = time.perf_counter()
        solve(h, -x, maps.settings.ridge)
        end = time.perf_counter()
        rows.append(
            (f"one map of {name}", f"{end - begin:.1f} s", f"{middle - begin:.1f} s histograms, the rest algebra", "")
        )
    return rows


def main() -> None:
    """Measure and print."""
    scenes = [perturb(shipped_cloud("bunny"), Perturbation(seed=seed)) for seed in range(SCENES)]
    table = Table("what", "time", "beside", "ratio")
    for row in [*histogram_rows(scenes), *registration_rows(scenes), *frame_rows(), *training_rows()]:
        table.add_row(*row)
    Console(width=150).print(table)


if __name__ == "__main__":
    main()
