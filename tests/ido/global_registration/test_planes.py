"""The cut plane: which of many a scene is likeliest under, and the way from there to the top."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize
from scipy.spatial.transform import Rotation

from ido import Cloud, GlobalModel, Perturbation, Scene, perturb
from ido.global_registration import GlobalSettings
from ido.global_registration.cut_plane import Posterior, likelihood_after, refine
from ido.global_registration.outliers import Background
from ido.global_registration.planes import KEPT, NO_PLANE
from ido.kernels import left_jacobian
from ido.methods import shipped_global_model
from ido.types import DoubleArray, FloatArray


@pytest.fixture(scope="module")
def model() -> GlobalModel:
    return shipped_global_model("bunny")


def posterior_of(model: GlobalModel, scene: Scene) -> Posterior:
    background = Background.of(scene.points, GlobalSettings(ball=False))
    share = float((~scene.is_outlier).mean())
    return Posterior(scene.points, background, model.fields[1], model.planes, np.array([share, 0.0]))


def test_each_plane_keeps_its_share_of_the_model(model: GlobalModel):
    planes = model.planes
    np.testing.assert_allclose(np.linalg.norm(planes.directions, axis=1), 1)
    along = planes.sample @ planes.directions.T
    kept = (along[:, :, None] < planes.offsets).mean(axis=0)
    np.testing.assert_allclose(kept, np.tile(KEPT, (len(planes.directions), 1)), atol=2 / len(planes.sample))


def test_the_likeliest_plane_is_that_of_the_formula(model: GlobalModel):
    rng = np.random.default_rng(3)
    planes, moved = model.planes, rng.uniform(-1, 1, (60, 3)).astype(np.float32)
    odds = np.exp(rng.normal(0, 2, 60)) * (moved[:, 0] < 0.1)
    along = moved.astype(np.float64) @ planes.directions.T
    kept_side = along[:, :, None] < planes.offsets
    values = np.log(1 + odds[:, None, None] * kept_side / KEPT).sum(axis=0)
    direction, number = np.unravel_index(values.argmax(), values.shape)
    assert values.max() > np.log(1 + odds).sum()
    normal, offset = planes.likeliest(moved, odds)
    np.testing.assert_array_equal(normal, planes.directions[direction])
    assert offset == planes.offsets[direction, number]


def test_what_a_plane_gains_is_that_of_the_formula(model: GlobalModel):
    rng = np.random.default_rng(4)
    planes, moved = model.few_planes, rng.uniform(-1, 1, (5, 60, 3)).astype(np.float32)
    odds = np.exp(rng.normal(1, 2, (5, 60))) * (moved[..., 0] < [[0.1], [0.5], [9], [-0.5], [-9]])
    along = moved.astype(np.float64) @ planes.directions.T
    kept_side = along[..., None] < planes.offsets
    values = np.log(1 + odds[..., None, None] * kept_side / planes.kept).sum(axis=1)
    expected = np.maximum(values.max(axis=(1, 2)) - np.log(1 + odds).sum(axis=1), 0)
    assert (expected > 1).sum() >= 2 and expected[-1] == 0
    np.testing.assert_allclose(planes.gains(moved, odds), expected, atol=0.06)  # of points that say next to nothing


def test_a_whole_scene_has_no_plane(model: GlobalModel):
    on_it = model.planes.sample[::3]
    assert model.planes.likeliest(on_it, np.full(len(on_it), 50.0)) is NO_PLANE
    assert model.planes.likeliest(on_it, np.zeros(len(on_it))) is NO_PLANE


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("incomplete", [0.3, 0.5, 0.7])
def test_the_plane_of_a_cut_scene_is_found_at_its_true_pose(
    bunny: Cloud, model: GlobalModel, incomplete: float, seed: int
):
    scene = perturb(bunny, Perturbation(points=800, incomplete=incomplete, noise=0.04, seed=seed))
    posterior, T = posterior_of(model, scene), scene.T_model_scene.astype(np.float64)
    refined = refine(posterior, T, cut=True)
    kept = float((model.planes.sample @ refined.normal < refined.offset).mean())
    assert kept == pytest.approx(1 - incomplete, abs=0.15)
    assert refined.log_likelihood >= posterior(T, *posterior.first_plane(T))[0]
    assert refined.log_likelihood > refine(posterior, T, cut=False).log_likelihood


def test_the_gradient_after_a_step(bunny: Cloud, model: GlobalModel):
    posterior = posterior_of(model, perturb(bunny, Perturbation(seed=2)))
    normal = np.array([0.6, 0.0, 0.8])
    tangents = np.linalg.svd(normal[None])[2][1:]
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec([0.3, -0.2, 0.1]).as_matrix()

    def after(step: DoubleArray) -> tuple[float, DoubleArray]:
        gradient = np.zeros(9)
        return likelihood_after(*posterior.data, T, normal, tangents, 0.2, step, gradient), gradient

    step = np.array([0.02, -0.01, 0.03, 0.05, 0.02, -0.04, 0.1, -0.2, 0.02])
    numeric = np.asarray(scipy.optimize.approx_fprime(step, lambda x: after(x)[0], 1e-5), dtype=float)
    np.testing.assert_allclose(after(step)[1], numeric, atol=0.02 * np.abs(numeric).max())


@pytest.mark.parametrize("turn", [[0.0, 0.0, 0.0], [1e-5, 0.0, 2e-5], [0.4, -1.2, 0.3], [0.0, 3.1, 0.0]])
def test_the_left_jacobian_is_how_a_turn_changes(turn: list[float]):
    φ = np.array(turn)

    def turned(δ: FloatArray) -> DoubleArray:
        return (Rotation.from_rotvec(φ + δ) * Rotation.from_rotvec(φ).inv()).as_rotvec()

    numeric = np.stack([(turned(h) - turned(-h)) / 2e-6 for h in 1e-6 * np.eye(3)], axis=1)
    np.testing.assert_allclose(left_jacobian(φ), numeric, atol=1e-6)
