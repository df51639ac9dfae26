"""How the global method registers: what it assumes of a scene, and how long it looks."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class GlobalSettings:
    """What is assumed of a scene. Each of the first three mirrors how scenes are made here, and can be left out.

    Args:
        cut_plane: whether one side of a plane may be missing from the scene.
        ball: whether outliers may gather in a Gaussian ball.
        known_volume: whether scattered outliers fill the cube that they are drawn from (±1.5 model units); else the
            bounding box of the scene.
        rotations: how many rotations the search tries.
    """

    cut_plane: bool = True
    ball: bool = True
    known_volume: bool = True
    rotations: int = 768

    def __post_init__(self) -> None:
        if not 1 <= self.rotations <= 4096:
            raise ValueError(f"rotations must lie between 1 and 4096, not {self.rotations}")
