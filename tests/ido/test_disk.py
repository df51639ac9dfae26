"""Outputs: written whole or not at all, through links, and never over what is read."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from ido import CloudError, Maps, MapsError, load_cloud
from ido.disk import check_apart, write_whole, written_beside


def test_a_file_takes_its_place_only_when_it_is_whole(tmp_path: Path):
    target = tmp_path / "a.txt"
    target.write_text("old")
    with pytest.raises(KeyError), written_beside(target) as beside:
        beside.write_text("half")
        assert target.read_text() == "old"
        raise KeyError
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]
    assert target.read_text() == "old"
    write_whole(target, b"new")
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("a.txt", "new")]


def test_a_link_stays_and_what_it_leads_to_is_replaced(tmp_path: Path):
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "a.txt", tmp_path / "link.txt"
    target.write_text("old")
    link.symlink_to(target)
    write_whole(link, b"new")
    assert link.is_symlink()
    assert target.read_text() == "new"


def test_files_that_differ_are_apart_even_when_they_are_not_there_yet(tmp_path: Path):
    check_apart({"-o": tmp_path / "a", "--moved": tmp_path / "b", "none": None}, {"the cloud": tmp_path / "c"})
    with pytest.raises(ValueError, match="--moved is -o itself"):
        check_apart({"-o": tmp_path / "a", "--moved": tmp_path / "x" / ".." / "a"}, {})


def bomb(path: Path, name: str) -> None:
    """An NPZ that promises 30 GB of zeros, and begins with some of them."""
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (1_250_000_000, 3)})
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(f"{name}.npy", head.getvalue() + bytes(1_000_000))


def test_what_would_unpack_to_gigabytes_is_refused_before_it_does(tmp_path: Path):
    bomb(tmp_path / "maps.npz", "maps")
    with pytest.raises(MapsError, match=r"maps\.npz: damaged \(it would unpack to 30\.0 GB\)"):
        Maps.load(tmp_path / "maps.npz")
    bomb(tmp_path / "cloud.npz", "points")
    with pytest.raises(CloudError, match=r"cloud\.npz: promises 1,250,000,000 points"):
        load_cloud(tmp_path / "cloud.npz")
