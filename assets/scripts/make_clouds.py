r"""Make the sample clouds, bunny.ply and urban.ply, and the bunny's surface, from public packages.

Fetch the packages first, the second on Debian 12 (what is read from them is checked):

    npm pack draco3d@1.5.9
    apt-get download libcgal-demo=5.5.1-2

then run

    python assets/scripts/make_clouds.py --draco draco3d-1.5.9.tgz \
        --cgal libcgal-demo_5.5.1-2_all.deb

Needs DracoPy, which the explorer itself does not (pip install DracoPy), and dpkg-deb.
See ATTRIBUTION.md for where the data come from and on what terms.
"""

import hashlib
import io
import subprocess
import tarfile
import tempfile
from pathlib import Path

import DracoPy  # pyright: ignore[reportMissingImports]
import numpy as np
import open3d as o3d
import trimesh
import tyro
from numpy.typing import NDArray

BUNNY = "package/bunny.drc"
BUNNY_SHA256 = "0cfb7a000e75024d6a02d81549d0609eb8cc45d5ef9a85152f6cdda56b4a48cc"

CGAL_DATA = "usr/share/doc/libcgal-dev/data.tar.gz"
URBAN = "data/points_3/b9_training.ply"
URBAN_SHA256 = "94c05829a78b1ebbb6882dda0e5e263f30331ff10820a0beb61843001ad0b46d"
# Subtracted in float64: float32 resolves the map's eastings to no better than 6 cm.
# Heights are small enough to stay as they are.
URBAN_ORIGIN = np.array([596_600.0, 243_600.0, 0.0])


def read_member(archive: Path, name: str, sha256: str) -> bytes:
    """Read one file of a tar archive; stop unless it is the expected one."""
    with tarfile.open(archive) as tar:
        member = tar.extractfile(name) if name in tar.getnames() else None
        if member is None:
            raise SystemExit(f"no {name} in {archive.name}: is it the right version?")
        content = member.read()
    found = hashlib.sha256(content).hexdigest()
    if found != sha256:
        raise SystemExit(f"{name} has the wrong sha256: {found}, expected {sha256}")
    return content


SURFACE_FACES = 6000
"""Of the bunny's surface: enough for a picture, and 100 kB."""


def read_bunny(draco: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Decode the vertices and faces of the Stanford Bunny."""
    mesh = DracoPy.decode(read_member(draco, BUNNY, BUNNY_SHA256))
    return np.asarray(mesh.points, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)


def simplified(points: NDArray[np.float64], faces: NDArray[np.int64]) -> trimesh.Trimesh:
    """A surface with fewer faces."""
    mesh = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(points), o3d.utility.Vector3iVector(faces))
    less = mesh.simplify_quadric_decimation(SURFACE_FACES)
    less.remove_unreferenced_vertices()
    return trimesh.Trimesh(np.asarray(less.vertices, dtype=np.float32), np.asarray(less.triangles), process=False)


def read_urban(cgal: Path) -> NDArray[np.float64]:
    """Read the urban scan relative to URBAN_ORIGIN; its label paint is not used."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["dpkg-deb", "-x", cgal, folder], check=True)
        content = read_member(Path(folder, CGAL_DATA), URBAN, URBAN_SHA256)
    scan = trimesh.load(io.BytesIO(content), file_type="ply")
    assert isinstance(scan, trimesh.PointCloud)
    return np.asarray(scan.vertices, dtype=np.float64) - URBAN_ORIGIN


def make_clouds(draco: Path, cgal: Path, out: Path = Path(__file__).parents[1]) -> None:
    """Write bunny.ply and urban.ply: binary, float32 x y z, vertices only; and the bunny's surface for pictures.

    Args:
        draco: The npm package draco3d 1.5.9 (draco3d-1.5.9.tgz).
        cgal: The Debian package libcgal-demo 5.5.1-2 (libcgal-demo_5.5.1-2_all.deb).
        out: The folder to write to.
    """
    bunny, faces = read_bunny(draco)
    simplified(bunny, faces).export(out / "bunny-surface.ply")
    clouds = {"bunny.ply": bunny, "urban.ply": read_urban(cgal)}
    for name, points in clouds.items():
        path = out / name
        trimesh.PointCloud(points).export(path)
        print(f"{name}: {len(points):,} points, {path.stat().st_size:,} bytes")


if __name__ == "__main__":
    tyro.cli(make_clouds)
