"""Learned maps as heatmaps: six rows, one for each coordinate of x, and a column for each bin."""

from __future__ import annotations

import base64
import html
import io
from functools import lru_cache

import numpy as np
import viser
from PIL import Image

from ido import Maps
from ido.poses import PARAMETERS
from ido.types import FloatArray
from ido_viz import palette
from ido_viz.charts import caption, method_span
from ido_viz.microscope import Inspection
from ido_viz.run import MethodRun, Run, bin_order
from ido_viz.state import NO_POINT, State

COMPARED = (1, 15, 30)
"""Numbers of the maps that the paper's figure compares."""

_ROW = 14  # height of a row, pixels


class Heatmap:
    """One side's map, following the iteration or pinned."""

    def __init__(self, gui: viser.GuiApi, side: int) -> None:
        self._side = side
        self._html = gui.add_html("")
        self._drawn: tuple[object, ...] | None = None

    def draw(self, run: Run, state: State, iteration: int, inspection: Inspection | None) -> None:
        """Draw the map that makes the next update, or the pinned one, with the picked bins marked."""
        side = run.sides[self._side]
        if side.maps is None:
            self._show((side.method, bool(side.waiting)), no_maps(side, self._side))
            return
        following = state.pinned_map == 0
        number = side.map_number(iteration) if following else min(state.pinned_map, len(side.maps.maps))
        order = bin_order(side.histogram, state.order, None if inspection is None else inspection.values)
        look = (id(side.maps), number, following, order.tobytes(), state.inspected)
        if look == self._drawn:
            return
        title = f"<b>{method_span(side.method, self._side)}</b> map {number} of {len(side.maps.maps)}"
        title += "" if following else " (pinned)"
        self._show(look, heatmap_html(side.maps, number, order, title, state.inspected))

    def _show(self, look: tuple[object, ...], content: str) -> None:
        if look != self._drawn:
            self._drawn = look
            self._html.content = content


class ComparedMaps:
    """Maps 1, 15 and 30 of both sides, as in the paper's figure.

    The order by contribution is one iteration's; these maps, which belong to several, are then by model index.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self._html = gui.add_html("")
        self._drawn: tuple[object, ...] | None = None

    def draw(self, run: Run, state: State) -> None:
        """Draw the compared maps of the shown methods."""
        of_sides = ((side.method, id(side.maps), bool(side.waiting)) for side in run.sides)
        look = (*of_sides, state.order, state.inspected)
        if look == self._drawn:
            return
        self._drawn = look
        parts = [no_maps(side, i) for i, side in enumerate(run.sides) if side.maps is None]
        for number in COMPARED:
            for i, side in enumerate(run.sides):
                if side.maps is None:
                    continue
                shown = min(number, len(side.maps.maps))
                title = f"{method_span(side.method, i)} map {shown}"
                order = bin_order(side.histogram, state.order)
                parts.append(heatmap_html(side.maps, shown, order, title, state.inspected))
        self._html.content = "".join(parts)


def no_maps(side: MethodRun, number: int) -> str:
    """What stands in the place of the maps of a baseline, or of a method that is not there yet, as HTML."""
    why = "has no maps yet" if side.waiting else "learns no maps"
    return caption(f"<b>{method_span(side.method, number)}</b> {why}")


def heatmap_html(maps: Maps, number: int, order: np.ndarray, title: str, marked: int = NO_POINT) -> str:
    """A map as a picture with named rows and blocks; `title` is HTML.

    Args:
        maps: the maps.
        number: of the map, from 1.
        order: of the bins, from left to right.
        title: HTML.
        marked: number of a model point whose bins are marked.
    """
    source, scale = _picture(maps, number, order.tobytes())
    rows = "".join(f'<div style="height:{_ROW}px">{name}</div>' for name in PARAMETERS)
    names = [name for block in maps.histogram.blocks for name in block]
    blocks = "".join(
        f'<div style="flex:1;text-align:center;border-top:3px solid {palette.css(palette.BLOCKS[i // 2 % 3])};'
        f'overflow:hidden">{html.escape(name)}</div>'
        for i, name in enumerate(names)
    )
    return (
        caption(f'{title}<span style="float:right">-{scale:.2g} {_KEY} {scale:.2g}</span>')
        + f'<div style="display:flex;margin:2px 8px 0 8px;font-size:0.625rem;line-height:{_ROW}px">'
        f'<div style="width:20px">{rows}</div><div style="position:relative;width:calc(100% - 20px)">'
        f'<img alt="heatmap of the map" src="{source}" style="width:100%;height:{6 * _ROW}px;display:block">'
        f"{_marks(order, len(maps.histogram.model.points), marked)}</div></div>"
        f'<div style="display:flex;margin:1px 8px 4px 28px;font-size:0.625rem;line-height:1.2">{blocks}</div>'
    )


def _marks(order: np.ndarray, n_model: int, marked: int) -> str:
    """A line across the rows at each bin of a model point."""
    return "".join(
        f'<div style="position:absolute;left:{100 * (place + 0.5) / order.size:.3f}%;top:-2px;width:4px;'
        f"height:{6 * _ROW + 4}px;margin-left:-2px;background:{palette.css(palette.MARK)};"
        'border:solid rgba(0, 0, 0, 0.8);border-width:0 1px;box-sizing:border-box"></div>'
        for place in np.flatnonzero(order % n_model == marked)
    )


@lru_cache(maxsize=512)
def _picture(maps: Maps, number: int, order: bytes) -> tuple[str, float]:
    """A PNG of a map as a data address, and the value at the ends of its colours. Rows are drawn enlarged."""
    values = maps.maps[number - 1][:, np.frombuffer(order, dtype=np.int64)]
    scale = float(np.quantile(np.abs(values), 0.995)) or 1.0
    levels = np.clip(np.rint((values / scale + 1) * 127.5), 0, 255).astype(np.uint8)
    picture = Image.fromarray(np.repeat(levels, _ROW, axis=0))
    picture.putpalette(_DIVERGING.tobytes())
    return png_address(picture), scale


def diverging_colors(values: FloatArray) -> np.ndarray:
    """Blue for negative, white for none and red for positive values; shape (n, 3)."""
    scale = float(np.quantile(np.abs(values), 0.99)) or 1.0
    return _DIVERGING[np.clip(np.rint((values / scale + 1) * 127.5), 0, 255).astype(np.uint8)]


def png_address(picture: Image.Image) -> str:
    """A picture as the data address of a PNG."""
    stream = io.BytesIO()
    picture.save(stream, format="PNG", compress_level=6)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()


def _diverging() -> np.ndarray:
    """256 colours from blue over white to red, even for people with a colour vision deficiency; shape (256, 3)."""
    stops = np.array([[5, 48, 97], [67, 147, 195], [247, 247, 247], [214, 96, 77], [103, 0, 31]], dtype=np.float64)
    at = np.linspace(0, len(stops) - 1, 256)
    channels = [np.interp(at, np.arange(len(stops)), stops[:, c]) for c in range(3)]
    return np.rint(np.stack(channels, axis=1)).astype(np.uint8)


_DIVERGING = _diverging()
_KEY = (
    '<span style="display:inline-block;width:44px;height:8px;background:linear-gradient(to right,'
    + ",".join(palette.css((int(r), int(g), int(b))) for r, g, b in _DIVERGING[::51])
    + ')"></span>'
)
