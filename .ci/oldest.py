"""Prints the lower bounds of pyproject's dependencies, as constraints for pip: `viser>=1.1.1,<2` as `viser==1.1.1`."""

import tomllib
from pathlib import Path

from packaging.requirements import Requirement

pyproject = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text(encoding="utf-8"))
for requirement in map(Requirement, pyproject["project"]["dependencies"]):
    if requirement.marker is None or requirement.marker.evaluate():
        (bound,) = (each.version for each in requirement.specifier if each.operator == ">=")
        print(f"{requirement.name}=={bound}")
