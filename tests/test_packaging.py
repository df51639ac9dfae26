"""What pyproject says is shipped; that the archives hold it is seen where they are built, in `.ci`."""

from __future__ import annotations

import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent


def test_every_folder_with_code_is_listed_as_a_package_and_has_an_init():
    pyproject = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = {file.parent for name in ("ido", "ido_viz") for file in (ROOT / name).rglob("*.py")}
    packages = {".".join(folder.relative_to(ROOT).parts) for folder in folders}
    assert set(pyproject["tool"]["setuptools"]["packages"]) == packages | {"ido.assets"}
    assert all((folder / "__init__.py").is_file() for folder in folders)
