"""The model in a pane: its surface or its shaded points, and the model points where they are looked into."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from ido_viz.core import palette
from ido_viz.core.frame import Frame
from ido_viz.core.inspection import Inspection
from ido_viz.core.model_picture import ModelPicture, picture_of

_OPACITY, _FAINT = 0.55, 0.18  # of the surface: by itself, and while the model points are looked at


class ModelView:
    """Draws the model of one pane under a node, in the model's frame."""

    def __init__(self, scene: viser.SceneApi, root: str) -> None:
        self._scene = scene
        self._root = root
        self._surface: Any = None
        self._shaded: Any = None
        self._points = scene.add_point_cloud(
            f"{root}/model-points", np.zeros((1, 3), np.float32), (0, 0, 0), point_size=0.022, point_shape="circle"
        )
        self._picture: ModelPicture | None = None
        self._look: tuple[object, ...] | None = None

    def draw(self, frame: Frame, pane: int, inspection: Inspection | None) -> None:
        """Draw the model of a pane; its points coloured by height or by their shares in what is looked into."""
        state, subject = frame.state, frame.run.subject
        model = frame.sides[pane].run.histogram.model
        shares = inspection.of_points if inspection is not None and state.coloring != "height" else None
        look = (model, subject, state.dark, shares is not None, inspection is not None and inspection.point is not None)
        if look == self._look and shares is None:
            return
        self._look = look
        picture = picture_of(subject)
        if picture is not self._picture:
            self._replace(picture)
        looked_into = inspection is not None and (shares is not None or inspection.point is not None)
        low, high = palette.model_greys(state.dark)
        if self._surface is not None:
            self._surface.color = palette.surface(state.dark)
            self._surface.opacity = _FAINT if looked_into else _OPACITY
        else:
            greys = np.repeat((low + (high - low) * picture.shades)[:, None], 3, axis=1)
            self._shaded.colors = greys.astype(np.uint8)
            self._shaded.point_size = 0.004 if looked_into else 0.009
        self._points.visible = looked_into
        self._points.points = model.points
        if shares is None:
            height = model.points @ np.array(subject.up)
            share = (height - height.min()) / max(float(np.ptp(height)), 1e-9)
            self._points.colors = np.repeat((low + (high - low) * share)[:, None], 3, axis=1).astype(np.uint8)
        else:
            self._points.colors = palette.diverging_colors(shares)

    def _replace(self, picture: ModelPicture) -> None:
        """Put another picture in the place of the last one."""
        for old in (self._surface, self._shaded):
            if old is not None:
                old.remove()
        self._surface = self._shaded = None
        if len(picture.faces):
            self._surface = self._scene.add_mesh_simple(
                f"{self._root}/surface",
                picture.vertices.astype(np.float32),
                picture.faces.astype(np.uint32),
                opacity=_OPACITY,
                material="toon5",  # shaded in steps, at half the cost of viser's standard where a browser has no card
                side="front",
                cast_shadow=False,
                receive_shadow=False,
            )
        else:
            self._shaded = self._scene.add_point_cloud(
                f"{self._root}/shaded", picture.vertices, (0, 0, 0), point_size=0.009, point_shape="circle"
            )
        self._picture = picture
