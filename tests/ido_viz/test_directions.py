"""The house: which package may import which. One direction, so that a change is felt downstream only."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import ido
import ido_viz

METHOD, EXPLORER = (Path(package.__path__[0]) for package in (ido, ido_viz))
MAY_IMPORT = {
    "core": set[str](),
    "canvas": {"core"},
    "panels": {"core"},
    "files": {"core", "canvas"},
    "teach": {"core", "canvas", "panels"},
    "serving": set[str](),
    "own": {"core", "panels", "serving"},
    "page": {"core", "canvas", "panels", "files", "teach", "own"},
    "live_state": {"core", "page"},
    "requests": {"core", "canvas", "live_state"},
    "session": {"core", "own", "page", "requests"},
    "app": {"core", "own", "session", "serving", "teach"},
    "notebook": {"core", "app", "teach"},
    "command": {"core", "own", "app", "serving", "teach"},
    "__main__": {"command"},
    "__init__": {"notebook"},
}
"""The packages and modules of `ido_viz`, from the ground up, and what each may import of it besides itself."""

WITHOUT_VISER = ("core",)

METHOD_ROWS = (
    ("types", "console", "one_thread", "processes"),
    ("poses", "clouds", "compiling", "kernels"),
    ("disk", "npz", "files"),
    ("perturbation",),
    ("blocks",),
    ("histograms", "bin_order"),
    ("maps",),
    ("folding", "training", "registration", "scores", "attribution"),
    ("baselines", "peers"),
    ("recording", "results"),
    ("shipped",),
    ("global_registration",),
    ("extensions", "methods"),
    ("experiments",),
    ("arguments", "user_units", "quality", "scans", "global_scans", "scan_folder"),
    ("registering", "cli"),
    ("__init__",),
)
"""The modules and packages of `ido`, from the ground up: each imports only from its row and those before."""


def modules(folder: Path) -> dict[str, Path]:
    """Each module by its name within the package, such as ``core.state``."""
    return {".".join(path.relative_to(folder).with_suffix("").parts): path for path in folder.rglob("*.py")}


def imports(path: Path) -> Iterator[str]:
    """The full names that a module imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name}: imports are written in full"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


ROOMS = {name: path for name, path in modules(EXPLORER).items() if name.split(".")[-1] != "__init__" or "." not in name}


@pytest.mark.parametrize("name", ROOMS)
def test_a_room_imports_only_what_lies_below_it(name: str):
    room = name.split(".")[0]
    below = {found.split(".")[1] for found in imports(ROOMS[name]) if found.startswith("ido_viz.")}
    assert below <= MAY_IMPORT[room] | {room}, f"{name} imports {sorted(below - MAY_IMPORT[room] - {room})}"
    if room in WITHOUT_VISER:
        assert not [found for found in imports(ROOMS[name]) if found.split(".")[0] == "viser"]


def test_the_rooms_are_those_that_there_are_and_none_lies_above_what_it_imports():
    order = list(MAY_IMPORT)
    assert {name.split(".")[0] for name in ROOMS} == set(order)
    assert all(order.index(below) < order.index(room) for room, its in MAY_IMPORT.items() for below in its)


def test_the_method_s_modules_import_only_from_their_row_and_those_before():
    row = {name: number for number, names in enumerate(METHOD_ROWS) for name in names}
    assert set(row) == {name.split(".")[0] for name in modules(METHOD)}
    for name, path in modules(METHOD).items():
        below = {found.split(".")[1] for found in imports(path) if found.startswith("ido.")}
        for other in below & set(row):
            assert row[other] <= row[name.split(".")[0]], f"{name} imports {other}"


def imported_modules(folder: Path) -> dict[str, set[str]]:
    """What each module of a package imports of it; a name that a package hands on is of that package's `__init__`."""
    known = {f"{folder.name}.{name}".removesuffix(".__init__"): path for name, path in modules(folder).items()}

    def module_of(name: str) -> str:
        while name and name not in known:
            name = name.rpartition(".")[0]
        return name

    return {name: {module_of(found) for found in imports(path)} - {name, ""} for name, path in known.items()}


def test_a_name_that_a_package_hands_on_counts_as_an_import_of_it():
    edges = imported_modules(METHOD)
    assert "ido.files" in edges["ido.arguments"]
    assert "ido.registration" in edges["ido"]
    assert "ido" not in set().union(*edges.values())


@pytest.mark.parametrize("folder", [METHOD, EXPLORER], ids=lambda folder: folder.name)
def test_no_module_imports_itself_through_others(folder: Path):
    edges = imported_modules(folder)
    done: set[str] = set()

    def visit(name: str, way: tuple[str, ...]) -> None:
        assert name not in way, " → ".join((*way[way.index(name) :], name))
        if name not in done:
            for other in edges.get(name, ()):
                visit(other, (*way, name))
            done.add(name)

    for name in edges:
        visit(name, ())


@pytest.mark.parametrize("path", modules(METHOD).values(), ids=modules(METHOD))
def test_the_method_knows_nothing_of_the_page(path: Path):
    assert not [found for found in imports(path) if found.split(".")[0] in ("ido_viz", "viser")]


def test_no_two_modules_have_the_same_name():
    names = [name.split(".")[-1] for folder in (METHOD, EXPLORER) for name in modules(folder)]
    assert {name for name in names if names.count(name) > 1 and not name.startswith("__")} == set()
