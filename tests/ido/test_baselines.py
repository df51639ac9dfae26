"""The baselines against independent computations, and against the easy case that each must solve."""

from __future__ import annotations

import itertools

import numpy as np
import open3d as o3d
import pytest
import scipy.optimize
from scipy.spatial.transform import Rotation

from ido import Cloud, Perturbation, Scene, StopReason, perturb, poses, score, shipped_cloud, shipped_maps
from ido.baselines import BCPD, CPD, ICP, KCCE, Baseline, GMMReg, Nothing
from ido.baselines.baseline import Record
from ido.baselines.gaussian import best_pose, gaussian_sums, mean_distance2, normalised, reference_sums, soft_share
from ido.baselines.gmmreg import correlation_cost
from ido.methods import BASELINES, method_names, shipped_method
from ido.types import DoubleArray, FloatArray

WORKING = [baseline for baseline in BASELINES.values() if not isinstance(baseline, Nothing)]
IDS = [name for name in BASELINES if name != Nothing.title]


@pytest.fixture(scope="module")
def bunny() -> Cloud:
    return shipped_cloud("bunny")


@pytest.fixture(scope="module")
def model() -> DoubleArray:
    return shipped_maps("bunny", "front-back").histogram.model.points.astype(np.float64)


@pytest.fixture(scope="module")
def scene(bunny: Cloud) -> Scene:
    return perturb(bunny, Perturbation(rotation=40, translation=0.2, seed=3))


@pytest.mark.parametrize("baseline", WORKING, ids=IDS)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_easy_case(baseline: Baseline, seed: int, bunny: Cloud, model: DoubleArray) -> None:
    clean = Perturbation(noise=0, points=1000, outliers=0, incomplete=0, rotation=30, translation=0, seed=seed)
    easy = perturb(bunny, clean)
    track = baseline.register(model, easy.points)
    assert track.stop is StopReason.CONVERGED
    assert score(easy, np.eye(4)).accuracy < 0.1
    assert score(easy, track.T_model_scene[-1]).accuracy == 1.0


@pytest.mark.parametrize("baseline", WORKING, ids=IDS)
def test_a_trajectory_is_rigid_starts_where_the_scene_lies_and_counts_its_steps(
    baseline: Baseline, scene: Scene, model: DoubleArray
) -> None:
    seen: list[int] = []
    track = baseline.register(model, scene.points, watch=seen.append)
    T = track.T_model_scene
    assert np.allclose(T[0], np.eye(4))
    assert seen == list(range(1, track.iterations + 1))
    assert len(T) == track.iterations + 1 <= baseline.max_iterations + 1
    assert np.allclose(T[:, :3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2), np.eye(3), atol=1e-9)
    assert np.allclose(np.linalg.det(T[:, :3, :3]), 1)
    steps = [np.linalg.norm(poses.log(after @ np.linalg.inv(before))) for before, after in itertools.pairwise(T)]
    assert np.allclose(track.update_norms, steps, atol=1e-6)


@pytest.mark.parametrize("baseline", WORKING, ids=IDS)
def test_the_order_of_the_points_does_not_matter(baseline: Baseline, scene: Scene, model: DoubleArray) -> None:
    shuffled = np.random.default_rng(0).permutation(scene.points)
    one = baseline.register(model, scene.points).T_model_scene[-1]
    other = baseline.register(model, shuffled).T_model_scene[-1]
    assert np.allclose(one, other, atol=2e-3)


@pytest.mark.parametrize("baseline", WORKING, ids=IDS)
def test_a_registration_can_be_cancelled(baseline: Baseline, scene: Scene, model: DoubleArray) -> None:
    class EnoughError(Exception):
        pass

    def watch(iterations: int) -> None:
        if iterations == 3:
            raise EnoughError

    with pytest.raises(EnoughError):
        baseline.register(model, scene.points, watch=watch)


@pytest.mark.parametrize("baseline", WORKING, ids=IDS)
def test_bad_clouds_are_refused_and_odd_ones_survived(baseline: Baseline, model: DoubleArray) -> None:
    with pytest.raises(ValueError, match="not finite"):
        baseline.register(model, np.full((10, 3), np.nan))
    with pytest.raises(ValueError, match="at least 3 points"):
        baseline.register(model, np.zeros((2, 3)))
    rng = np.random.default_rng(0)
    flat = rng.uniform(-1, 1, (100, 3)) * [1, 1, 0]
    for odd in (np.zeros((10, 3)), flat, 500 + rng.normal(size=(50, 3))):
        track = baseline.register(model, odd)  # must not raise
        assert track.stop is not StopReason.DIVERGED or track.iterations < baseline.max_iterations


def test_a_pose_out_of_this_world_ends_as_diverged(model: DoubleArray) -> None:
    class Wild(Nothing):
        def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
            record(np.eye(4))
            record(np.full((4, 4), np.nan))
            return StopReason.CONVERGED

    track = Wild().register(model, model)
    assert track.stop is StopReason.DIVERGED
    assert track.iterations == 1


def test_the_iteration_limit(scene: Scene, model: DoubleArray) -> None:
    for limited in (ICP(max_iterations=4), CPD(max_iterations=4), GMMReg(max_iterations=4), KCCE(max_iterations=4)):
        track = limited.register(model, scene.points)
        assert (track.iterations, track.stop) == (4, StopReason.MAX_ITERATIONS), limited.title


@pytest.mark.parametrize("sigma2", [1.0, 0.05, 0.002])
def test_the_compiled_sums_are_those_of_numpy(sigma2: float, scene: Scene, model: DoubleArray) -> None:
    for compiled, exact in zip(
        gaussian_sums(scene.points, model, sigma2), reference_sums(scene.points, model, sigma2), strict=True
    ):
        assert np.abs(compiled - exact).max() <= 1e-4 * np.abs(exact).max()


def test_weights_do_not_vanish_far_away(model: DoubleArray) -> None:
    sums = gaussian_sums(model[:5] + 100, model, 1e-3)
    assert (sums.weight > 0.999).all()
    assert np.isfinite(sums.target).all()


def test_the_share_of_a_point_falls_with_the_outliers_density_and_with_distance(model: DoubleArray) -> None:
    far = np.array([[1.0, 0, 0], [3.0, 0, 0], [50.0, 0, 0]])
    sums = gaussian_sums(far, model, 0.05)
    shares = [soft_share(sums, 0.05, density) for density in (0.0, 1e-3, 1.0)]
    assert (shares[0] == 1).all()
    assert (shares[1][:2] > shares[2][:2]).all()
    assert (np.diff(shares[2]) <= 0).all()
    assert np.isfinite(shares[2]).all()


def test_the_best_pose_is_scipys(model: DoubleArray) -> None:
    rng = np.random.default_rng(1)
    source, weight = model[:40], rng.uniform(0, 1, 40)
    turn = Rotation.random(rng=rng)
    target = turn.apply(source) + [0.3, -0.2, 0.1] + 0.05 * rng.normal(size=source.shape)
    T = best_pose(source, target, weight)
    means = [(weight[:, None] * cloud).sum(axis=0) / weight.sum() for cloud in (source, target)]
    expected = Rotation.align_vectors(target - means[1], source - means[0], weights=weight)[0]
    assert np.allclose(T[:3, :3], expected.as_matrix())
    assert np.allclose(T[:3, 3], means[1] - expected.apply(means[0]))


def test_mirrored_clouds_are_turned_not_mirrored(model: DoubleArray) -> None:
    T = best_pose(model, model * [-1, 1, 1], np.ones(len(model)))
    assert np.isclose(np.linalg.det(T[:3, :3]), 1)


@pytest.mark.parametrize("cutoff", [float("inf"), 0.4])
def test_icp_is_open3ds(cutoff: float, scene: Scene, model: DoubleArray) -> None:
    ours = ICP(cutoff=cutoff, tolerance=0, max_iterations=12).register(model, scene.points)
    clouds = [o3d.geometry.PointCloud(o3d.utility.Vector3dVector(c.astype(float))) for c in (scene.points, model)]
    criteria = o3d.pipelines.registration.ICPConvergenceCriteria(
        relative_fitness=0, relative_rmse=0, max_iteration=ours.iterations
    )
    reach = min(cutoff, 1e3)
    theirs = o3d.pipelines.registration.registration_icp(*clouds, reach, criteria=criteria)
    assert np.allclose(ours.T_model_scene[-1], theirs.transformation, atol=1e-6)


def expectation_maximisation(
    model: FloatArray, scene: FloatArray, outlier: str, w: float, iterations: int
) -> list[DoubleArray]:
    """Rigid EM with the whole matrix P, as the papers of CPD and BCPD print it."""
    n_model, n_scene = len(model), len(scene)
    centre, size = model.mean(axis=0), np.sqrt(((model - model.mean(axis=0)) ** 2).sum(axis=1).mean())
    y, x = (model - centre) / size, (scene - centre) / size
    sigma2 = ((x[:, None] - y[None]) ** 2).sum() / (3 * n_model * n_scene)
    R, t, found = np.eye(3), np.zeros(3), []
    for _ in range(iterations):
        moved = x @ R.T + t
        g = np.exp(-((y[:, None] - moved[None]) ** 2).sum(axis=2) / (2 * sigma2))  # (M, S)
        if outlier == "CPD":
            c = (2 * np.pi * sigma2) ** 1.5 * w / (1 - w) * n_model / n_scene
        else:
            c = (2 * np.pi * sigma2) ** 1.5 * w * n_model / ((1 - w) * np.prod(x.max(axis=0) - x.min(axis=0)))
        P = g / (g.sum(axis=0) + c)
        n_p = P.sum()
        mean_x, mean_y = x.T @ P.sum(axis=0) / n_p, y.T @ P.sum(axis=1) / n_p
        A = (y - mean_y).T @ P @ (x - mean_x)
        U, _, Vt = np.linalg.svd(A)
        R = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
        t = mean_y - R @ mean_x
        sigma2 = (P * ((y[:, None] - (x @ R.T + t)[None]) ** 2).sum(axis=2)).sum() / (3 * n_p)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R, centre + size * t - R @ centre
        found.append(T)
    return found


@pytest.mark.parametrize("w", [0.1, 0.5])
def test_cpd_and_bcpd_are_the_printed_equations(w: float, scene: Scene, model: DoubleArray) -> None:
    ours: dict[str, Baseline] = {
        "CPD": CPD(normalisation="together", outliers=w, max_iterations=25, tolerance=0),
        "BCPD": BCPD(outliers=w, max_iterations=25),
    }
    for name, baseline in ours.items():
        expected = expectation_maximisation(model, scene.points.astype(float), name, w, 25)
        assert np.allclose(baseline.register(model, scene.points).T_model_scene[1:], expected, atol=2e-4), name


def test_the_first_sigma_of_the_mixtures(scene: Scene, model: DoubleArray) -> None:
    pairs = ((model[:, None] - scene.points[None]) ** 2).sum(axis=2)
    assert np.isclose(mean_distance2(scene.points.astype(float), model), pairs.mean())


def test_a_pose_between_normalised_clouds_comes_back_to_model_units(scene: Scene, model: DoubleArray) -> None:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix(), [0.4, 0.1, -0.3]
    together = normalised(model, scene.points, "together")
    moved = poses.transform(T, together.scene) * together.model_scale + together.model_centre
    assert np.allclose(poses.transform(together.pose(T), scene.points.astype(float)), moved)
    each = normalised(model, scene.points, "each")
    for cloud in (each.model, each.scene):
        assert np.allclose(cloud.mean(axis=0), 0)
        assert np.isclose((cloud**2).sum(axis=1).mean(), 1)
    middle = scene.points.astype(float).mean(axis=0)
    goal = each.model_centre + each.model_scale * T[:3, 3]
    assert np.allclose(poses.transform(each.pose(T), middle[None]), goal)


def test_nothing_to_match_is_told(model: DoubleArray) -> None:
    far = model + np.array([50.0, 0, 0])
    assert ICP(cutoff=0.3).register(model, far).stop is StopReason.NOTHING_NEAR


def test_units_change_cpd_when_each_cloud_has_its_own(scene: Scene, model: DoubleArray) -> None:
    each, together = (CPD(normalisation=n).register(model, scene.points) for n in ("each", "together"))
    assert not np.allclose(each.T_model_scene[-1], together.T_model_scene[-1], atol=0.05)


@pytest.mark.parametrize("phi", [(0.0, 0.0, 0.0), (0.6, -0.4, 0.9), (0.0, 0.0, 3.1)])
def test_the_cost_of_gmmreg_and_its_gradient(phi: tuple[float, ...], scene: Scene, model: DoubleArray) -> None:
    parameters = np.array([0.1, -0.2, 0.05, *phi])
    points, sigma = scene.points.astype(np.float64)[:60], 0.5

    def cost(parameters: FloatArray) -> float:
        moved = Rotation.from_rotvec(parameters[3:]).apply(points) + parameters[:3]
        return float(-np.exp(-((model[:, None] - moved[None]) ** 2).sum(axis=2) / sigma**2).mean())

    value, gradient = correlation_cost(parameters, model, points, sigma)
    assert np.isclose(value, cost(parameters), rtol=1e-5)
    assert np.allclose(gradient, scipy.optimize.approx_fprime(parameters, cost, 1e-6), atol=1e-5)


def test_kernel_correlation_never_falls_at_one_width(scene: Scene, model: DoubleArray) -> None:
    track = KCCE(start=0.3, end=0.3, steps=15, tolerance=0).register(model, scene.points)
    correlation = [
        np.exp(-((model[:, None] - moved[None]) ** 2).sum(axis=2) / (2 * 0.3**2)).sum()
        for moved in poses.transform(track.T_model_scene, scene.points.astype(float))
    ]
    assert track.iterations == 15
    assert (np.diff(correlation) > -1e-4 * correlation[0]).all()
    assert correlation[-1] > 1.05 * correlation[0]


def test_methods_by_name(scene: Scene) -> None:
    names = method_names("bunny")
    assert len(set(names)) == len(names)
    for name in names:
        method = shipped_method("bunny", name)
        assert method.name == name
        assert (method.maps is None) == (name in BASELINES)
        assert len(method.model.points) == 514
        assert method.settings
    assert "Improved DO (as printed)" not in method_names("urban")
    assert "reconstruction" in next(name for name in names if "KCCE" in name)
    with pytest.raises(ValueError, match="unknown shape"):
        shipped_method("cow", "DO")
    with pytest.raises(ValueError, match="cannot register"):
        shipped_method("urban", "Improved DO (as printed)")
