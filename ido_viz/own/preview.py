"""What lies in the middle of the canvas instead of the panes: a cloud before training, or a scan on its model."""

from __future__ import annotations

import html
from collections.abc import Callable

import numpy as np
import viser

from ido.types import FloatArray
from ido_viz.core import palette
from ido_viz.core.geometry import quaternion, upright
from ido_viz.core.library import Subject
from ido_viz.core.model_picture import picture_of
from ido_viz.own.draft import UPS, Draft

NORMAL_LENGTH = 0.09
"""Of the drawn normals, model units."""

_LARGER = 1.5  # than in a pane, for it has the place of two
_ROOT = "/own"
_CAPTION = """<style>.over-canvas:not(.of-preview) {{ visibility: hidden; }}
.names.of-preview {{ height: 7rem; }} .of-preview > div {{ white-space: normal; }}</style>
<div class="over-canvas names of-preview" style="color:{color}"><div><b style="font-size:1.15rem">{title}</b><br>
<span style="font-size:0.8rem">{what}.<br>Numbers and charts beside it are those of the panes.</span></div></div>"""


class Preview:
    """One picture at a time; its title stands where the preview is made, which must be beside all tabs.

    Args:
        client: the page.
        show_panes: hides or shows the panes.
        dark: whether the page is.
    """

    def __init__(self, client: viser.ClientHandle, show_panes: Callable[[bool], None], *, dark: bool) -> None:
        self._scene = client.scene
        self._show_panes = show_panes
        self._style = client.gui.add_html("")
        self._root: viser.FrameHandle | None = None
        self.dark = dark

    def show_draft(self, draft: Draft) -> None:
        """The cloud, its model points, and their normals, dark at the point and bright at the tip."""
        what = "Grey: the cloud. Large points: the model, with its normals, bright at their tips"
        self._begin(UPS[draft.up], draft.name, what)
        self._points("cloud", draft.in_file.points, palette.GUIDE, 0.006)
        model = draft.model
        ends = np.stack([model.points, model.points + np.float32(NORMAL_LENGTH) * model.normals], axis=1)
        colors = np.empty((len(ends), 2, 3), dtype=np.uint8)
        colors[:, 0], colors[:, 1] = palette.ink(self.dark), palette.method_color("Improved DO", self.dark)
        self._scene.add_line_segments(
            f"{_ROOT}/normals", _LARGER * ends, colors, thickness=2.0, thickness_units="screen"
        )
        self._points("model", model.points, palette.ink(self.dark), 0.02)

    def show_scan(self, name: str, subject: Subject, placed: FloatArray) -> None:
        """A scan where it was moved to, points (N, 3) in model units, on the model."""
        self._begin(subject.up, name, "Orange: the scan, moved. Grey: what it was registered to")
        self._points("model", picture_of(subject).vertices, palette.GUIDE, 0.008)
        self._points("scan", placed.astype(np.float32), palette.method_color("Improved DO", self.dark), 0.02)

    def hide(self) -> None:
        """The panes again."""
        if self._root is not None:
            self._root.remove()
            self._root = None
            self._style.content = ""
            self._show_panes(True)

    def _begin(self, up: tuple[float, float, float], title: str, what: str) -> None:
        if self._root is not None:
            self._root.remove()
        self._root = self._scene.add_frame(_ROOT, show_axes=False, wxyz=quaternion(upright(up)))
        color = palette.css(palette.ink(self.dark))
        self._style.content = _CAPTION.format(color=color, title=html.escape(title), what=what)
        self._show_panes(False)

    def _points(self, name: str, points: FloatArray, color: palette.Color, size: float) -> None:
        self._scene.add_point_cloud(f"{_ROOT}/{name}", _LARGER * points, color, point_size=size, point_shape="circle")
