"""The paper's "triple-binary" diagram at a model point: the surface on which the answer of a question changes."""

from __future__ import annotations

import numpy as np
import viser

from ido import Model, Question
from ido.types import FloatArray
from ido_viz.canvas.ball import add_ball
from ido_viz.core import palette
from ido_viz.core.palette import Color


class Diagram:
    """Draws the diagram of one pane, in the model's frame under a node."""

    def __init__(self, scene: viser.SceneApi, root: str) -> None:
        self._scene = scene
        self._root = f"{root}/diagram"
        self._shown: tuple[object, ...] | None = None

    def draw(
        self,
        model: Model,
        point: int | None,
        question: Question | None,
        color: Color,
        partner: FloatArray | None,
        *,
        named_above: FloatArray | None = None,
    ) -> None:
        """Draw the diagram of a model point and one of its questions; nothing for no point.

        Args:
            model: whose point it is.
            point: its number.
            question: one of its questions; the point alone for None.
            color: of the question.
            partner: the one scene point that it is asked about, in the model's frame, shape (3,).
            named_above: the direction in which the point's number stands above it, shape (3,); None for no number.
        """
        places = [None if place is None else place.tobytes() for place in (partner, named_above)]
        look = (model, point, question, color, *places)
        if look == self._shown:
            return
        self._shown = None  # should it fail
        self._scene.remove_by_name(self._root)
        if point is not None:
            self._make(model, point, question, color, partner, named_above)
        self._shown = look

    def _make(
        self,
        model: Model,
        point: int,
        question: Question | None,
        color: Color,
        partner: FloatArray | None,
        named_above: FloatArray | None,
    ) -> None:
        m, n = model.points[point].astype(np.float64), model.normals[point].astype(np.float64)
        self._scene.add_frame(self._root, show_axes=False)
        add_ball(self._scene, f"{self._root}/point", m, 0.06, palette.MARK)
        if named_above is not None:
            words = f"model point {point}"
            self._scene.add_label(f"{self._root}/name", words, position=m + 0.1 * named_above, anchor="bottom-center")
        if question is not None:
            surface = question.surface(m, n)
            self._mesh(surface.vertices, surface.faces, color)
            self._lines("lines", surface.lines, color)
            self._lines("guides", surface.guides, palette.GUIDE)
        if partner is not None:
            add_ball(self._scene, f"{self._root}/partner", partner, 0.04, palette.MARK)
            self._lines("pair", np.array([[m, partner]]), palette.MARK)

    def _mesh(self, vertices: FloatArray, faces: np.ndarray, color: Color) -> None:
        self._scene.add_mesh_simple(
            f"{self._root}/surface",
            vertices.astype(np.float32),
            faces.astype(np.uint32),
            color=color,
            opacity=0.3,
            side="double",
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )

    def _lines(self, name: str, segments: FloatArray, color: Color) -> None:
        if len(segments):
            self._scene.add_line_segments(
                f"{self._root}/{name}",
                segments.astype(np.float32),
                np.array(color),
                thickness=3.0,
                thickness_units="screen",
            )
