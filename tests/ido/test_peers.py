"""The peers: they do what their libraries do when called by hand, and say what to install where one is missing."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterator
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ido import Cloud, Perturbation, Scene, StopReason, cli, perturb, score, shipped_cloud
from ido.experiments.families import COMPARED_METHODS
from ido.experiments.tune import CANDIDATES
from ido.experiments.workers import local_executor
from ido.methods import BASELINES, PEERS, is_installed, shipped_method
from ido.peers import FGR, GICP, KISS, RANSAC, Peer, PeerError
from ido.peers.peer import register_once
from ido.types import FloatArray

INSTALLED = [name for name in PEERS if is_installed(name)]
CLEAN = Perturbation(noise=0, points=2500, outliers=0, incomplete=0, rotation=30, translation=0, seed=1)
FINE: tuple[Peer, ...] = (RANSAC(voxel=0.1), FGR(voxel=0.1, distance_gain=1.0), GICP(downsampling=0.1), KISS(voxel=0.1))
"""Settings fine enough for the shipped shapes."""


@pytest.fixture(scope="module")
def bunny() -> Cloud:
    return shipped_cloud("bunny")


@pytest.fixture(scope="module")
def scene(bunny: Cloud) -> Scene:
    return perturb(bunny, CLEAN)


def skip_without(peer: Peer) -> None:
    pytest.importorskip(peer.package)


@pytest.mark.parametrize("peer", FINE, ids=lambda peer: peer.title)
def test_the_easy_case(peer: Peer, bunny: Cloud, scene: Scene):
    skip_without(peer)
    seen: list[int] = []
    track = register_once(peer.title, peer.onto(bunny.points), scene.points, watch=seen.append)
    T = track.T_model_scene
    assert np.allclose(T[0], np.eye(4)) and len(T) == 2 and seen == [1]
    assert np.allclose(T[1, :3, :3] @ T[1, :3, :3].T, np.eye(3), atol=1e-5) and np.linalg.det(T[1, :3, :3]) > 0
    assert score(scene, T[0]).accuracy < 0.1
    assert score(scene, T[1]).accuracy > 0.95


@pytest.fixture(scope="module")
def worker() -> Iterator[Executor]:
    """One of an experiment: libraries have one thread there, without which RANSAC may end elsewhere each time."""
    with local_executor(1) as (executor, _):
        yield executor


def registered_twice(name: str, points: FloatArray) -> list[FloatArray]:
    method = shipped_method("bunny", name)
    return [method.register(points).T_model_scene[-1] for _ in range(2)]


@pytest.mark.parametrize("name", INSTALLED)
def test_by_name_they_give_the_same_pose_twice_and_refuse_bad_clouds(name: str, bunny: Cloud, worker: Executor):
    method = shipped_method("bunny", name)
    assert method.name == name and method.settings == PEERS[name].settings
    points = perturb(bunny, Perturbation(seed=2)).points
    one, other = worker.submit(registered_twice, name, points).result()
    if not name.startswith("KISS"):  # its threads add up in any order
        assert np.allclose(one, other, atol=1e-6)
    with pytest.raises(ValueError, match="not finite"):
        method.register(np.full((10, 3), np.nan))
    with pytest.raises(ValueError, match="at least 3 points"):
        method.register(np.zeros((2, 3)))


def threads_with_open3d(*, registering: bool) -> int:
    """How many a fresh process has after a registration, or after nothing but the import."""
    scene = perturb(shipped_cloud("urban"), Perturbation(seed=2))
    if registering:
        shipped_method("urban", "Open3D RANSAC, tuned").register(scene.points)
    else:
        importlib.import_module("open3d")
    return len(list(Path("/proc/self/task").iterdir()))


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="this system cannot bind a process to a processor")
def test_open3d_has_one_thread_and_leaves_the_processors_to_others():
    with local_executor(1) as (executor, _):
        imported = executor.submit(threads_with_open3d, registering=False).result()  # one more in Open3D 0.19
    with local_executor(1) as (executor, _):
        assert executor.submit(threads_with_open3d, registering=True).result() == imported
        assert executor.submit(os.sched_getaffinity, 0).result() == os.sched_getaffinity(0)


def test_gicp_is_small_gicps_own_call(bunny: Cloud, scene: Scene):
    small_gicp = pytest.importorskip("small_gicp")
    ours = register_once("", GICP(downsampling=0.05).onto(bunny.points), scene.points)
    theirs = small_gicp.align(bunny.points.astype(float), scene.points.astype(float), downsampling_resolution=0.05)
    assert np.allclose(ours.T_model_scene[-1], theirs.T_target_source, atol=1e-3)
    assert (ours.stop is StopReason.CONVERGED) == theirs.converged


def test_kiss_matcher_is_the_librarys_own_call_and_tells_where_it_finds_nothing(bunny: Cloud, scene: Scene):
    kiss_matcher = pytest.importorskip("kiss_matcher")
    track = register_once("", KISS(voxel=0.1).onto(bunny.points), scene.points)
    theirs = kiss_matcher.KISSMatcher(0.1).estimate(scene.points, bunny.points.astype(np.float32))
    assert theirs.valid and track.stop is StopReason.CONVERGED
    assert np.allclose(track.T_model_scene[-1, :3, :3], theirs.rotation, atol=0.02)
    assert np.allclose(track.T_model_scene[-1, :3, 3], theirs.translation, atol=0.02)
    scattered = np.random.default_rng(0).uniform(-1, 1, (40, 3))
    nothing = register_once("", KISS(voxel=0.3).onto(bunny.points), scattered)
    assert nothing.stop is StopReason.NOTHING_NEAR and np.allclose(nothing.T_model_scene[-1], np.eye(4))


def test_ransac_and_fgr_follow_open3ds_tutorial(bunny: Cloud, scene: Scene):
    """The tutorial's own lines, with its voxel; RANSAC and FGR then differ in what they match with."""
    import open3d as o3d  # not by the workers, which read this file too

    voxel, registration = 0.1, o3d.pipelines.registration

    def preprocessed(points: np.ndarray) -> tuple[Any, Any]:
        down = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points.astype(float))).voxel_down_sample(voxel)
        down.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(radius=voxel * 2, max_nn=30))
        near = o3d.geometry.KDTreeSearchParamHybrid(radius=voxel * 5, max_nn=100)
        return down, registration.compute_fpfh_feature(down, near)

    (source, source_fpfh), (target, target_fpfh) = preprocessed(scene.points), preprocessed(bunny.points)
    fast = registration.registration_fgr_based_on_feature_matching(
        source,
        target,
        source_fpfh,
        target_fpfh,
        registration.FastGlobalRegistrationOption(maximum_correspondence_distance=voxel * 0.5),
    )
    plane = registration.TransformationEstimationPointToPlane()
    refined = registration.registration_icp(source, target, voxel * 0.4, fast.transformation, plane)
    ours = register_once("", FGR(voxel=voxel).onto(bunny.points), scene.points)
    assert np.allclose(ours.T_model_scene[-1], refined.transformation, atol=1e-4)
    assert RANSAC().settings == {
        **{"voxel": 0.05, "normal_gain": 2.0, "feature_gain": 5.0, "distance_gain": 1.5, "refine_gain": 0.4},
        **{"max_iterations": 100_000, "confidence": 0.999, "similarity": 0.9},
    }


def test_every_peer_is_tuned_over_as_many_settings_as_icp():
    for title in {peer.title for peer in PEERS.values()}:
        assert len(set(CANDIDATES[title])) == len(CANDIDATES["ICP"])
        assert PEERS[f"{title}, tuned"] in CANDIDATES[title]
    assert not set(PEERS) & set(BASELINES)


def test_a_missing_library_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], bunny: Cloud
):
    monkeypatch.setitem(sys.modules, "kiss_matcher", None)
    assert not KISS.is_installed() and not is_installed("KISS-Matcher, tuned") and is_installed("DO")
    with pytest.raises(PeerError, match=r"KISS-Matcher needs one more package: pip install 'ido-explorer\[peers\]'"):
        KISS().onto(bunny.points)
    shipped_method.cache_clear()
    named = ["experiment", "run", "-o", str(tmp_path / "a.sqlite"), "--scenes", "1", "--methods"]
    assert cli.main([*named, "KISS-Matcher, default"]) == 2
    assert "pip install 'ido-explorer[peers]'" in capfd.readouterr().err
    assert not (tmp_path / "a.sqlite").exists()
    assert "KISS-Matcher, default" in COMPARED_METHODS
