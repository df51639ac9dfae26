"""The tab Training: how the shown methods' maps were trained (paper, Fig. "Training Curves")."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import viser
from PIL import Image

from ido import Maps
from ido_viz.core import palette
from ido_viz.core.chart_data import padded
from ido_viz.core.frame import Frame
from ido_viz.panels.maps_tab import png_address
from ido_viz.panels.markup import both_methods, caption, method_span, no_maps
from ido_viz.panels.plot import Plot, plain_axes


class TrainingTab:
    """Training error of both sides' maps: its mean, its deviation, and its rotation and translation parts."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._caption = gui.add_html("")
        self._plots = {}
        for name, title in (
            ("mean", "mean training error ‖x* - x‖² after each map"),
            ("deviation", "its standard deviation over the samples"),
            ("rotation", "its rotation part, rad²"),
            ("translation", "its translation part"),
        ):
            gui.add_html(caption(title))
            self._plots[name] = Plot(gui, height=88)
        self._samples = gui.add_html("")
        self._look: tuple[object, ...] | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the training curves of the shown methods."""
        run, state = frame.run, frame.state
        look = (*((side.method, side.maps, bool(side.waiting)) for side in run.sides), state.dark, state.large_text)
        if look == self._look:
            return
        self._look = look
        idle = "".join(no_maps(side, state.dark) for side in run.sides if side.maps is None)
        self._caption.content = caption(both_methods(run, state.dark)) + idle
        series: list[Any] = [{"label": "maps"}]
        for side, width in zip(run.sides, (4, 1.5), strict=True):  # so that equal curves are both seen
            color = palette.method_color(side.method, state.dark)
            series.append({"stroke": palette.css(color), "width": width, "points": {"show": False}})
        for name, plot in self._plots.items():
            curves = [
                np.log10(np.maximum(getattr(side.maps.curves, name), 1e-12)) if side.maps else np.full(2, np.nan)
                for side in run.sides
            ]
            length = max(len(values) for values in curves)
            lowest = min(-3, math.floor(np.nanmin(np.concatenate([*curves, [0.0]]))))
            scales = {
                "x": {"time": False, "auto": False, "range": (0.0, float(length - 1))},
                "y": {"auto": False, "range": (lowest - 0.5, 0.3)},
            }
            data = (np.arange(length, dtype=np.float64), *(padded(values, length) for values in curves))
            plot.restyle(data, series, scales, plain_axes(state, powers=(lowest, 0)))
        self._samples.content = "".join(
            _samples_html(side.maps, f"{method_span(side.method, state.dark)} {part} error", columns)
            for part, columns in (("rotation", slice(3, 6)), ("translation", slice(0, 3)))
            for side in run.sides
            if side.maps
        )


_LEVELS = 40  # rows of the picture of the samples' errors


def _samples_html(maps: Maps, title: str, columns: slice) -> str:
    """How the samples' errors spread after each map, from left to right; darker where more samples are."""
    errors = np.linalg.norm(maps.curves.residuals[:, :, columns].astype(np.float64), axis=2)
    top = float(np.quantile(errors[0], 0.99)) or 1.0
    edges = np.linspace(0.0, top, _LEVELS + 1)
    counts = np.stack([np.histogram(np.clip(row, 0.0, top), bins=edges)[0] for row in errors], axis=1)[::-1]
    shades = 255 * (1 - np.log1p(counts) / np.log1p(counts.max()))
    source = png_address(Image.fromarray(np.rint(shades).astype(np.uint8)))
    return (
        caption(f'{title} of {errors.shape[1]} samples<span style="float:right">0 to {top:.2g}</span>')
        + f'<img alt="spread of the training errors" src="{source}" style="display:block;width:calc(100% - 16px);'
        f'height:70px;margin:2px 8px 6px 8px;image-rendering:pixelated">'
    )
