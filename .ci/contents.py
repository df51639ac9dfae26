"""Compares what the archives in a folder hold with the repository's files: `contents.py DIST`.

The source archive has to hold all but hidden ones, the wheel both packages, and as `ido.assets` all of `assets` but
what is named here.
"""

import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

NOT_SHIPPED = ("assets/docs/", "assets/examples/", "assets/explorer.", "assets/scripts/")
MADE = ("PKG-INFO", "setup.cfg", "ido_explorer.egg-info/", "ido_explorer-")
"""What building adds."""


def check(archive: Path, found: list[str], expected: list[str]) -> None:
    found = [name for name in found if not name.startswith(MADE)]
    missing, extra = sorted(set(expected) - set(found)), sorted(set(found) - set(expected))
    print(f"{archive.name}: {len(found)} files of the repository, {archive.stat().st_size / 1e6:.1f} MB")
    if missing or extra:
        sys.exit(f"missing: {', '.join(missing) or 'none'}\nnot expected: {', '.join(extra) or 'none'}")


dist = Path(sys.argv[1])
tracked = subprocess.run(["git", "ls-files"], check=True, capture_output=True, text=True).stdout.splitlines()

(sdist,) = dist.glob("*.tar.gz")
with tarfile.open(sdist) as archive:
    names = [each.name.partition("/")[2] for each in archive if each.isfile()]
check(sdist, names, [name for name in tracked if not name.startswith(".")])

(wheel,) = dist.glob("*.whl")
with zipfile.ZipFile(wheel) as archive:
    names = archive.namelist()
shipped = [name for name in tracked if name.startswith(("ido/", "ido_viz/"))]
shipped += [f"ido/{name}" for name in tracked if name.startswith("assets/") and not name.startswith(NOT_SHIPPED)]
check(wheel, names, shipped)
