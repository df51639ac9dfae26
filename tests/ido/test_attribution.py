"""Shares in an update: they add up to what registration really did."""

from __future__ import annotations

import numpy as np
import pytest

from ido import Perturbation, perturb, register, shipped_cloud, shipped_maps
from ido.attribution import Attribution, bin_name, strongest

CASES = [("bunny", "front-back"), ("bunny", "triple-binary"), ("urban", "triple-binary")]


@pytest.mark.parametrize(("shape", "name"), CASES)
def test_the_shares_add_up_to_the_update(shape: str, name: str) -> None:
    maps = shipped_maps(shape, name)
    points = perturb(shipped_cloud(shape), Perturbation(seed=4)).points
    track = register(maps, points, max_iterations=35)
    for k in (0, 1, 14, 29, 33):
        if k >= track.iterations:
            continue
        D = maps.maps[min(k, 29)]
        shares = Attribution.of(D, maps.histogram, maps.histogram(points, track.x[k]))
        made = track.x[k + 1] - track.x[k]
        np.testing.assert_allclose(shares.update, made, atol=1e-6)
        np.testing.assert_allclose(shares.of_points.sum(axis=1), made, atol=1e-6)
        np.testing.assert_allclose(shares.of_blocks.sum(axis=1), made, atol=1e-6)
        assert np.isclose(shares.along().sum(), track.update_norms[k], atol=1e-6)
        assert np.isclose(shares.along(np.eye(6)[2]).sum(), made[2], atol=1e-6)


def test_against_the_reference_the_model_itself_has_no_share() -> None:
    maps = shipped_maps("bunny", "triple-binary")
    reference = maps.histogram.reference
    shares = Attribution.of(maps.maps[0], maps.histogram, reference, against_reference=True)
    assert not shares.of_bins.any()
    assert not shares.along().any()
    points = perturb(shipped_cloud("bunny"), Perturbation(seed=4)).points
    h = maps.histogram(points, np.zeros(6))
    both = [Attribution.of(maps.maps[0], maps.histogram, h, against_reference=against) for against in (False, True)]
    at_reference = -maps.maps[0].astype(np.float64) @ reference
    np.testing.assert_allclose(both[0].update - both[1].update, at_reference, atol=1e-6)


def test_points_and_blocks_are_sums_of_the_right_bins() -> None:
    histogram = shipped_maps("bunny", "triple-binary").histogram
    n_model = len(histogram.model.points)
    of_bins = np.random.default_rng(0).normal(size=(6, histogram.n_bins))
    shares = Attribution(of_bins, histogram)
    names = [bin_name(histogram, number) for number in range(histogram.n_bins)]
    for point in (0, 7, n_model - 1):
        own = [j for j, (_, a) in enumerate(names) if a == point]
        assert [names[j][0] for j in own] == ["front", "back", "up", "down", "clockwise", "anticlockwise"]
        np.testing.assert_allclose(shares.of_points[:, point], of_bins[:, own].sum(axis=1))
    ups = [j for j, (side, _) in enumerate(names) if side in ("up", "down")]
    np.testing.assert_allclose(shares.of_blocks[:, 1], of_bins[:, ups].sum(axis=1))


def test_the_strongest_come_first_whatever_their_sign() -> None:
    values = np.array([0.1, -3.0, 2.0, 0.0, -0.2])
    assert strongest(values, 3).tolist() == [1, 2, 4]
    assert len(strongest(values, 99)) == len(values)
