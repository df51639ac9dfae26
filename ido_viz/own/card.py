"""A quality card: how well maps do on fresh scenes, by the level of each perturbation, kept beside them."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ido import Cloud, Maps
from ido.disk import write_whole
from ido.experiments import LEVELS, sweep

SCENES = 20
"""Scenes at each level."""

Row = tuple[float, ...]
"""Mean PointAcc at each level of a sweep."""


@dataclass(frozen=True, slots=True)
class Card:
    """Mean PointAcc on scenes that no training had, by method and sweep, at the sweep's levels.

    In each sweep one perturbation takes its levels and the others keep the paper's test defaults.
    """

    rows: Mapping[str, Mapping[str, Row]]

    @classmethod
    def of(cls, cloud: Cloud, maps: Mapping[str, Maps]) -> Card:
        """Measure maps on their cloud."""
        return cls(
            {
                method: {
                    name: tuple(sweep(cloud, its, name, scenes=SCENES)[..., 0].mean(axis=1).tolist()) for name in LEVELS
                }
                for method, its in maps.items()
            }
        )

    @staticmethod
    def name_of(maps: Mapping[str, Maps]) -> str:
        """A name for the file of the card of these maps, which other maps, or the same by other names, do not have."""
        digest = hashlib.sha256()
        for method, its in maps.items():
            digest.update(f"{method}/{its.arrays()['header']}/".encode())  # it has the checksum of all the rest
        return f"card-{digest.hexdigest()[:16]}.json"

    def save(self, path: Path) -> None:
        """Write it, whole or not at all."""
        write_whole(path, json.dumps({"scenes": SCENES, "levels": LEVELS, "PointAcc": self.rows}).encode())

    @classmethod
    def load(cls, path: Path) -> Card | None:
        """Read it; None when there is none, or it is not as it should be, and must be measured anew."""
        try:
            rows = json.loads(path.read_text("utf-8"))["PointAcc"]
            read = {
                str(method): {name: tuple(float(value) for value in its[name]) for name in LEVELS}
                for method, its in rows.items()
            }
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            return None
        fits = all(
            len(row) == len(LEVELS[name]) and all(math.isfinite(value) for value in row)
            for its in read.values()
            for name, row in its.items()
        )
        return cls(read) if read and fits else None
