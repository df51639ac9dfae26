"""A ball that marks a point in the 3D view, as bright as its colour is: what light falls on makes it dull."""

from __future__ import annotations

import numpy as np
import viser

from ido.types import FloatArray
from ido_viz.core import palette
from ido_viz.core.palette import Color

_AROUND = np.linspace(0.0, 2 * np.pi, 33)


def add_ball(scene: viser.SceneApi, name: str, place: FloatArray, radius: float, color: Color) -> None:
    """Draw a ball of a radius (model units) at a place (3,), set off from any ground by three rings."""
    scene.add_point_cloud(
        name,
        np.zeros((1, 3), dtype=np.float32),
        np.array(color),
        point_size=2 * radius,
        point_shape="circle",
        point_shading="flat",
        position=place,
    )
    circle = radius * np.stack([np.cos(_AROUND), np.sin(_AROUND), np.zeros(33)], axis=1)
    rings = np.concatenate(
        [np.stack([ring[:-1], ring[1:]], axis=1) for ring in (np.roll(circle, i, 1) for i in range(3))]
    )
    scene.add_line_segments(
        f"{name}/rim", rings.astype(np.float32), np.array(palette.RIM), thickness=1.5, thickness_units="screen"
    )
