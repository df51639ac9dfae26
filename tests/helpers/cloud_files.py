"""Files of clouds as others write them, also broken ones: every variant that the documents tell of."""

from __future__ import annotations

import gzip
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import laspy
import lzf
import numpy as np
import trimesh

from ido.types import FloatArray

POINTS = np.round(np.random.default_rng(0).normal([300, -20, 5], [40, 10, 2], (60, 3)), 2)
"""What every whole variant holds, to a hundredth of its unit."""

COLOURS = np.random.default_rng(1).integers(0, 256, (60, 3)).astype(np.uint8)


@dataclass(frozen=True, slots=True)
class Variant:
    """A file.

    Args:
        name: of the file; unique.
        what: what it is, as the documents say it.
        content: its bytes.
        refused: the reason for which it is refused, as a part of the message; empty when it is read.
        noted: what is said of what was left out, as a part of the note; empty when nothing is.
    """

    name: str
    what: str
    content: bytes
    refused: str = ""
    noted: str = ""

    def write(self, folder: Path) -> Path:
        path = folder / self.name
        path.write_bytes(self.content)
        return path


def lines(points: FloatArray = POINTS, separator: str = " ", more: Callable[[int], str] = lambda i: "") -> list[str]:
    """A line for each point."""
    return [separator.join(f"{value:.2f}" for value in point) + more(i) for i, point in enumerate(points)]


def text(*rows: str, encoding: str = "utf-8") -> bytes:
    return ("\n".join(rows) + "\n").encode(encoding)


def colour(separator: str) -> Callable[[int], str]:
    return lambda i: separator + separator.join(map(str, COLOURS[i]))


def ply(
    kind: str = "float", order: str = "<", points: FloatArray = POINTS, count: int | None = None, faces: bytes = b""
) -> bytes:
    """A binary file of points, whose head may promise another number; faces with three corners each may follow."""
    format_name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    size = {"float": "f4", "double": "f8", "int": "i4"}[kind]
    head = [
        "ply",
        f"format {format_name} 1.0",
        "comment made by a scanner",
        f"element vertex {len(points) if count is None else count}",
        *(f"property {kind} {axis}" for axis in "xyz"),
        *([f"element face {len(faces) // 13}", "property list uchar int vertex_indices"] if faces else []),
        "end_header",
    ]
    return text(*head) + points.astype(order + size).tobytes() + faces


def ply_text(count: int = 60, rows: int = 60) -> bytes:
    head = ["ply", "format ascii 1.0", f"element vertex {count}", *(f"property double {axis}" for axis in "xyz")]
    return text(*head, "end_header", *lines()[:rows])


def faces(*triangles: tuple[int, int, int]) -> bytes:
    return b"".join(struct.pack("<B3i", 3, *triangle) for triangle in triangles)


def pcd(data: str, size: int = 4, count: int = 60, rows: int = 60, kind: str = "F") -> bytes:
    """A file of points and a label; its head may promise another number of points than there are."""
    head = [
        "# .PCD v0.7 - Point Cloud Data file format",
        "VERSION 0.7",
        "FIELDS x y z label",
        f"SIZE {size} {size} {size} 2",
        f"TYPE {kind} {kind} {kind} U",
        "COUNT 1 1 1 1",
        f"WIDTH {count}",
        "HEIGHT 1",
        "VIEWPOINT 0 0 0 1 0 0 0",
        f"POINTS {count}",
        f"DATA {data}",
    ]
    if data == "ascii":
        return text(*head, *lines(POINTS[:rows], more=lambda i: f" {i}"))
    number = {"F": "<f", "I": "<i"}[kind] + str(size)
    table = np.empty(rows, dtype=[("x", number), ("y", number), ("z", number), ("label", "<u2")])
    table["x"], table["y"], table["z"] = POINTS[:rows].T
    table["label"] = np.arange(rows)
    if data == "binary":
        return text(*head) + table.tobytes()
    content = b"".join(table[name].tobytes() for name in ("x", "y", "z", "label"))
    packed = lzf.compress(content, 2 * len(content))
    return text(*head) + struct.pack("<II", len(packed), len(content)) + packed


def npy(array: np.ndarray) -> bytes:
    return made("a.npy", lambda path: np.save(path, array))


def npz(**arrays: np.ndarray) -> bytes:
    return made("a.npz", lambda path: np.savez(path, allow_pickle=False, **arrays))


def las(name: str, point_format: int = 3, version: str = "1.2") -> bytes:
    def write(path: Path) -> None:
        header = laspy.LasHeader(point_format=point_format, version=version)
        header.scales = np.full(3, 0.01)
        header.offsets = np.zeros(3)
        scan = laspy.LasData(header)
        scan.x, scan.y, scan.z = POINTS.T
        scan["intensity"] = np.arange(60)
        scan["return_number"] = scan["number_of_returns"] = np.ones(60, dtype=np.uint8)
        scan.write(str(path))

    return made(name, write)


def made(name: str, write: Callable[[Path], object]) -> bytes:
    """What a library writes to a file of this name."""
    with TemporaryDirectory() as folder:
        write(Path(folder) / name)
        return (Path(folder) / name).read_bytes()


def at(content: bytes, place: int, new: bytes) -> bytes:
    return content[:place] + new + content[place + len(new) :]


_BOX = trimesh.creation.box()
_HOLED = POINTS.copy()
_HOLED[7, 1] = np.nan
_DECIMAL_COMMAS = [line.replace(".", ",") for line in lines()]
_HALF = faces(*((i, i + 1, i + 2) for i in range(28)))
_LAS, _LAZ = las("a.las"), las("a.laz")
_LAYERED = las("a.laz", 6, "1.4")
_MANY, _FIFTY, _SEVENTY = (struct.pack("<I", count) for count in (10**8, 50, 70))
_COUNT, _COUNT_1_4, _BOUNDS = 107, 247, 179  # places in the head of a LAS
_STL, _STL_TEXT = (made("a.stl", lambda path, kind=kind: _BOX.export(str(path), kind)) for kind in ("stl", "stl_ascii"))

VARIANTS = (
    Variant("blanks.xyz", "blanks between columns", text(*lines())),
    Variant("tabs.txt", "tabs between columns", text(*lines(separator="\t"))),
    Variant("commas.csv", "commas between columns", text(*lines(separator=","))),
    Variant("commas-and-blanks.csv", "commas and blanks after them", text(*lines(separator=", "))),
    Variant(
        "semicolons.csv", "semicolons between columns, also at the end", text(*lines(separator=";", more=lambda i: ";"))
    ),
    Variant("colours.asc", "more columns of numbers", text(*lines(more=colour(" ")))),
    Variant("words.txt", "more columns of words", text(*lines(more=lambda i: " wall"))),
    Variant(
        "names.csv",
        "a first line of names, in another order",
        text("Z;Y;X;red", *(f"{z};{y};{x};7" for x, y, z in POINTS)),
    ),
    Variant("cloudcompare.txt", "names in a comment", text("//X,Y,Z,R,G,B", *lines(separator=",", more=colour(",")))),
    Variant("mark.csv", "a byte order mark", text("x,y,z", *lines(separator=","), encoding="utf-8-sig")),
    Variant("utf16.txt", "UTF-16", text(*lines(), encoding="utf-16")),
    Variant("count.pts", "a count in the first line", text("60", *lines(more=lambda i: " -1200 9 9 9"))),
    Variant("comments.xyz", "comments, also behind points", text("# scan", *lines(more=lambda i: " # good"))),
    Variant("windows.xyz", "lines that end as on Windows", "\r\n".join(lines()).encode()),
    Variant("packed.xyz.gz", "packed with gzip", gzip.compress(text(*lines()))),
    Variant(
        "short.pts",
        "fewer points than its count",
        text("60", *lines()[:50]),
        "promises 60 points, 50 follow",
    ),
    Variant(
        "decimal.txt",
        "decimal commas, blanks between columns",
        text(*_DECIMAL_COMMAS),
        "write decimal points",
    ),
    Variant(
        "decimal.csv",
        "decimal commas, semicolons between columns",
        text(*(line.replace(" ", ";") for line in _DECIMAL_COMMAS)),
        "line 1: ",
    ),
    Variant(
        "all-commas.csv",
        "decimal commas, commas between columns",
        text(*(line.replace(" ", ",") for line in _DECIMAL_COMMAS)),
        "may stand within numbers",
    ),
    Variant(
        "thousands.csv",
        "commas between thousands, semicolons between columns",
        text(*(";".join(f"{1000 * value:,.2f}" for value in point) for point in POINTS)),
        "no marks between thousands",
    ),
    Variant(
        "blanks-in-numbers.txt",
        "blanks between thousands, tabs between columns",
        text(*("\t".join(f"{1000 * value:,.2f}".replace(",", " ") for value in point) for point in POINTS)),
        "no marks between thousands",
    ),
    Variant(
        "only-blanks.txt",
        "blanks between thousands and between columns",
        text(*(" ".join(f"{5e5 + 1000 * value:,.2f}".replace(",", " ") for value in point) for point in POINTS)),
        "may stand within numbers",
    ),
    Variant(
        "mixed.txt",
        "another separator from line 31 on",
        text(*lines()[:30], *lines(separator=",")[30:]),
        "line 31",
    ),
    Variant("ragged.xyz", "a line of two columns", text(*lines()[:20], "1.5 2.5", *lines()[20:]), "line 21 has 2"),
    Variant(
        "word.xyz",
        "a word where a number belongs",
        text(*lines()[:20], "1 2 n/a", *lines()[20:]),
        "line 21: 'n/a'",
    ),
    Variant(
        "numbered.txt",
        "a first column that counts",
        text(*(f"{i} {line}" for i, line in enumerate(lines()))),
        "only counts",
    ),
    Variant(
        "names.txt",
        "a first line without x, y and z",
        text("a b c", *lines()),
        "names of columns x, y and z",
    ),
    Variant("holed.xyz", "a point that is not finite", text(*lines(_HOLED)), "1 of 60 points"),
    Variant("floats.ply", "binary", ply()),
    Variant("doubles.ply", "binary, 64 bits", ply("double")),
    Variant("big-endian.ply", "binary, most significant byte first", ply(order=">")),
    Variant("text.ply", "text", ply_text()),
    Variant(
        "one-face.ply",
        "a scan with one face",
        ply(faces=faces((0, 1, 2))),
        noted="57 of 60 points belong to none of its 1 faces",
    ),
    Variant(
        "half-meshed.ply",
        "a scan, half of it meshed",
        ply(faces=_HALF),
        noted="30 of 60 points belong to none of its 28 faces",
    ),
    Variant("short.ply", "binary, cut off", ply()[:-50], "promises 60 rows, it holds 55"),
    Variant("short-text.ply", "text, cut off", ply_text(rows=50), "promises 60 rows, it holds 50"),
    Variant("long.ply", "more points than it promises", ply(count=50), "holds 10 rows more"),
    Variant("long-text.ply", "text, more points than it promises", ply_text(count=50), "holds 10 rows more"),
    Variant("many.ply", "promises 4 billion points", ply(count=4 * 10**9), "thin it to at most"),
    Variant("claims.ply", "promises 40 million points and has 60", ply(count=4 * 10**7), "it holds 60"),
    Variant("text.pcd", "text", pcd("ascii")),
    Variant("binary.pcd", "binary", pcd("binary")),
    Variant("doubles.pcd", "binary, 64 bits", pcd("binary", 8)),
    Variant("packed.pcd", "compressed", pcd("binary_compressed")),
    Variant("packed-doubles.pcd", "compressed, 64 bits", pcd("binary_compressed", 8)),
    Variant("short.pcd", "binary, cut off", pcd("binary", rows=50), "promises 60 rows, it holds 50"),
    Variant("short-text.pcd", "text, cut off", pcd("ascii", rows=50), "promises 60 rows, it holds 50"),
    Variant("short-packed.pcd", "compressed, cut off", pcd("binary_compressed")[:-20], "is cut off"),
    Variant(
        "claims.pcd",
        "promises 40 million points and has 10",
        pcd("binary", count=4 * 10**7, rows=10),
        "it holds 10",
    ),
    Variant(
        "bomb.pcd",
        "compressed, promises 40 million points",
        pcd("binary_compressed", count=4 * 10**7, rows=10),
        "promises",
    ),
    Variant("points.npy", "an array (N, 3)", npy(POINTS)),
    Variant(
        "fields.npy",
        "an array with fields x, y, z",
        npy(np.array(list(map(tuple, POINTS)), [(a, "f8") for a in "XYZ"])),
    ),
    Variant("points.npz", "an array named points among others", npz(points=POINTS, other=POINTS[:9])),
    Variant("only.npz", "one array (N, 3)", npz(scan=POINTS, intensity=POINTS[:, 0])),
    Variant("two.npz", "two arrays (N, 3)", npz(a=POINTS, b=POINTS), "needs an array 'points'"),
    Variant("short.npy", "cut off", npy(POINTS)[:-8], "is cut off"),
    Variant("turned.npy", "an array (3, N)", npy(POINTS.T), "three columns"),
    Variant("objects.npy", "Python objects", npy(np.array([[1, 2, object()]] * 20)), "Python objects"),
    Variant("scan.las", "LAS", _LAS),
    Variant("scan.laz", "LAZ", _LAZ),
    Variant("short.las", "LAS, cut off", _LAS[:-500], "is cut off"),
    Variant("short.laz", "LAZ, cut off", _LAZ[:-100], "LAZ"),
    Variant("many.las", "LAS that promises 100 million points", at(_LAS, _COUNT, _MANY), "thin it to at most"),
    Variant("claims.las", "LAS that promises 70 points", at(_LAS, _COUNT, _SEVENTY), "it holds 60"),
    Variant("claims.laz", "LAZ that promises 70 points", at(_LAZ, _COUNT, _SEVENTY), "LAZ"),
    Variant("long.las", "LAS that promises 50 points", at(_LAS, _COUNT, _FIFTY), "holds 60 points"),
    Variant("long.laz", "LAZ that promises 50 points", at(_LAZ, _COUNT, _FIFTY), "holds 60 points"),
    Variant("layered.laz", "LAZ of a newer kind of points", _LAYERED),
    Variant(
        "claims-layered.laz", "the same that promises 70 points", at(_LAYERED, _COUNT_1_4, _SEVENTY), "it holds 60"
    ),
    Variant(
        "long-layered.laz", "the same that promises 50 points", at(_LAYERED, _COUNT_1_4, _FIFTY), "holds 60 points"
    ),
    Variant(
        "bounds.las",
        "LAS whose points do not reach as far as its head says",
        at(_LAS, _BOUNDS, struct.pack("<d", 1e3)),
        noted="do not fill the bounds",
    ),
    Variant("vertices.obj", "vertices alone", text(*(f"v {line}" for line in lines()))),
    Variant("vertices.off", "vertices alone", text("OFF", "60 0 0", *lines())),
    Variant("short.off", "cut off", text("OFF", "60 1 0", *lines()), "is cut off"),
    Variant("long.off", "more points than it promises", text("OFF", "50 0 0", *lines()), "holds more than it promises"),
    Variant("face.off", "its last face cut off", text("OFF", "60 1 0", *lines(), "3 0 1"), "is no face"),
    Variant("short.stl", "binary, cut off", _STL[:-60], "promises 12 triangles and has room for 10"),
    Variant("long.stl", "binary, more triangles than it promises", _STL + _STL[-50:], "longer than that"),
    Variant("short-text.stl", "text, cut off", _STL_TEXT[:-200], "not every solid and facet ends"),
    Variant(
        "second.stl", "text, its second solid cut off", _STL_TEXT + _STL_TEXT[:300], "not every solid and facet ends"
    ),
    Variant(
        "corner.obj",
        "a face with a corner that is not there",
        text(*(f"v {line}" for line in lines()), "f 1 2 61"),
        "not there",
    ),
)
"""Every variant, in the order of the documents."""
