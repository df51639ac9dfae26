"""What the global method assumes of a scene."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class GlobalSettings:
    """What is assumed of a scene. Each of these mirrors how scenes are made here, and can be left out.

    Args:
        cut_plane: one side of a plane may be missing from the scene.
        ball: outliers may gather in a Gaussian ball.
        known_volume: scattered outliers fill the cube that they are drawn from (±1.5 model units); else the bounding
            box of the scene.
    """

    cut_plane: bool = True
    ball: bool = True
    known_volume: bool = True
