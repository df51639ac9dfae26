"""A cloud before training: what is read of a file, its size, its normals, and names that are only names."""

from __future__ import annotations

import gzip
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import trimesh

from ido import CloudError
from ido.files import save_cloud
from ido_viz.own import draft as draft_module
from ido_viz.own.draft import (
    LONGEST_NAME,
    MOST_POINTS,
    UPS,
    Draft,
    Facing,
    draft_of,
    open_upload,
    read_draft,
    shown_name,
)
from ido_viz.own.draft_folder import draft_html, means, read_length, side_text

HOSTILE = [
    "../../etc/passwd",
    "C:\\x.ply",
    "<img src=x onerror=alert(1)>.ply",
    "a\x00b\n.ply",
    "\u202eylp.x",
    " ",
    "…" * 500,
]


@pytest.fixture(scope="module")
def ellipsoid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    mesh = trimesh.creation.icosphere(3)
    mesh.apply_scale((3.0, 2.0, 1.0))
    path = tmp_path_factory.mktemp("draft") / "ellipsoid.ply"
    mesh.export(path)
    return path


@pytest.fixture(scope="module")
def draft(ellipsoid: Path) -> Draft:
    return read_draft(ellipsoid)


def test_a_mesh_has_its_size_and_says_what_is_made_of_it(draft: Draft):
    np.testing.assert_allclose(draft.size, [6.0, 4.0, 2.0], rtol=0.01)
    assert (draft.name, draft.read, len(draft.in_file.points)) == ("ellipsoid", 642, 30_000)
    assert any("1,280 faces" in note for note in draft.notes)
    assert "ellipsoid" in draft_html(draft) and "642 points read" in draft_html(draft)


def test_another_size_scales_the_cloud_about_the_file_s_origin_and_changes_no_shape(draft: Draft):
    larger = replace(draft, factor=25.4)
    original, scaled = (each.cloud.frame.to_user_units(each.cloud.points[:50]) for each in (draft, larger))
    np.testing.assert_allclose(scaled, 25.4 * original, rtol=1e-5)
    np.testing.assert_array_equal(larger.cloud.points, draft.cloud.points)
    assert side_text(larger) == f"{25.4 * draft.size.max():.6g}"


@pytest.mark.parametrize("up", UPS)
def test_normals_point_where_they_are_wanted(draft: Draft, up: str):
    normals = {facing: replace(draft, up=up, facing=facing).model.normals for facing in get_args(Facing)}
    points = draft.bare.points
    assert ((points * normals["outward"]).sum(axis=1) > 0).mean() > 0.98  # an ellipsoid is seen from its middle
    np.testing.assert_array_equal(normals["inward"], -normals["outward"])
    assert (normals["up"] @ np.array(UPS[up]) >= 0).all()
    np.testing.assert_array_equal(normals["down"], -normals["up"])
    for each in normals.values():
        np.testing.assert_allclose(np.abs((each * normals["outward"]).sum(axis=1)), 1.0, atol=1e-5)


def test_a_large_cloud_is_thinned_and_says_so(tmp_path: Path):
    points = np.random.default_rng(0).standard_normal((MOST_POINTS + 10_000, 3))
    save_cloud(tmp_path / "large.xyz", points)
    draft = read_draft(tmp_path / "large.xyz")
    assert len(draft.in_file.points) == MOST_POINTS
    assert any("40,000 points 30,000 are used" in note for note in draft.notes)


def test_a_cloud_of_few_points_has_a_model_of_as_many_different_ones(tmp_path: Path):
    points = np.random.default_rng(0).standard_normal((100, 3))
    save_cloud(tmp_path / "few.xyz", np.concatenate([points, points]))
    assert len(read_draft(tmp_path / "few.xyz").model.points) == 100


@pytest.mark.parametrize("name", ["cloud.ply", "CLOUD.PLY", "../cloud.ply", "a.b.ply"])
def test_an_upload_is_read_by_its_ending_and_lies_in_the_folder_alone(ellipsoid: Path, tmp_path: Path, name: str):
    folder = tmp_path / "inside"
    folder.mkdir()
    file, used = open_upload(name, ellipsoid.read_bytes(), folder)
    assert len(file.points) == 642 and draft_of(file, used, "x").read == 642
    assert list(tmp_path.rglob("*")) == [folder]


@pytest.mark.parametrize("name", [*HOSTILE, "cloud.exe", "cloud", ".ply.gz.gz", "cloud.ply/../x"])
def test_a_name_never_is_a_path_and_a_wrong_one_is_told_what_to_do(tmp_path: Path, name: str):
    with pytest.raises(CloudError) as error:
        open_upload(name, b"no cloud", tmp_path)
    assert "file.ply" not in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_a_packed_upload_is_read_and_one_that_unpacks_to_too_much_is_refused(
    ellipsoid: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    packed = gzip.compress(ellipsoid.read_bytes())
    assert len(open_upload("ellipsoid.ply.gz", packed, tmp_path)[0].points) == 642
    with pytest.raises(CloudError, match=r"^ellipsoid\.ply\.gz: is damaged or cut off"):
        open_upload("ellipsoid.ply.gz", packed[:500], tmp_path)
    monkeypatch.setattr(draft_module, "MOST_UNPACKED", 1 << 20)
    with pytest.raises(CloudError, match=r"^zeros\.xyz\.gz: unpacks to more than 1 MB"):
        open_upload("zeros.xyz.gz", gzip.compress(bytes(2 << 20)), tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", HOSTILE)
def test_a_shown_name_is_one_printable_line(name: str):
    shown = shown_name(name)
    assert 0 < len(shown) <= LONGEST_NAME
    assert shown.isprintable() and shown == shown.strip()


def test_a_name_is_text_on_the_page(draft: Draft):
    assert "<img" not in draft_html(replace(draft, name=shown_name(HOSTILE[2])))


@pytest.mark.parametrize(("text", "length"), [("2.5", 2.5), ("nonsense", 7.0), ("-1", 7.0), ("nan", 7.0), ("inf", 7.0)])
def test_a_length_that_cannot_be_meant_changes_nothing(text: str, length: float):
    assert read_length(text, 7.0) == length


@pytest.mark.parametrize(
    ("text", "its"),
    [("", True), (" ", True), ("12", True), ("12.", True), ("12.0", True), ("12.5", False), ("a", False)],
)
def test_a_length_is_left_as_it_is_written_while_it_means_the_same(text: str, its: bool):
    assert means(text, 12.0) == its
