"""The tab Maps: learned maps as heatmaps, six rows for the coordinates of x and a column for each bin."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Callable
from functools import lru_cache

import numpy as np
import viser
from PIL import Image

from ido import Maps
from ido.experiments.paper import COMPARED_MAPS
from ido.poses import PARAMETERS
from ido_viz.core import palette
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.state import NO_POINT, State
from ido_viz.core.wording import short_side
from ido_viz.panels.markup import caption, method_span, no_maps

_ROW = 14  # height of a row, pixels
_KEY = (
    '<span style="display:inline-block;width:44px;height:8px;background:linear-gradient(to right,'
    + ",".join(palette.css((int(r), int(g), int(b))) for r, g, b in palette.DIVERGING[::51])
    + ')"></span>'
)


class MapsTab:
    """The map of each pane, following the iteration or pinned, and below them maps 1, 15 and 30."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._shown = [_Pictures(gui) for _ in range(2)]
        self._compared = _Pictures(gui)

    def draw(self, frame: Frame) -> None:
        """Draw the maps, with the picked bins marked."""
        state = frame.state
        for pictures, side in zip(self._shown, frame.sides, strict=True):
            run = side.run
            look = (run.method, run.maps, bool(run.waiting), side.shown_map, state.pinned_map == 0, state.dark)
            look += (side.order.tobytes(), side.marked)
            pictures.draw(look, lambda side=side: _shown_html(side, state))
        of_sides = ((side.run.method, side.run.maps, bool(side.run.waiting), side.marked) for side in frame.sides)
        self._compared.draw((*of_sides, state.order, state.dark), lambda: _compared_html(frame))


class _Pictures:
    """HTML that is made only when what it depends on has changed."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._html = gui.add_html("")
        self._look: tuple[object, ...] | None = None

    def draw(self, look: tuple[object, ...], make: Callable[[], str]) -> None:
        if look != self._look:
            self._look = look
            self._html.content = make()


def _shown_html(side: SideFrame, state: State) -> str:
    """The map that makes the next update, or the pinned one."""
    run = side.run
    if run.maps is None:
        return no_maps(run, state.dark)
    title = f"<b>{method_span(run.method, state.dark)}</b> map {side.shown_map} of {len(run.maps.maps)}"
    title += " (pinned)" if state.pinned_map else ""
    return heatmap_html(run.maps, side.shown_map, side.order, title, side.marked, ("shown", side.pane))


def _compared_html(frame: Frame) -> str:
    """Maps 1, 15 and 30 of both sides.

    The order by contribution is one iteration's; these maps, which belong to several, are then by model index.
    """
    parts = [no_maps(side.run, frame.state.dark) for side in frame.sides if side.run.maps is None]
    numbers = sorted({number for side in frame.sides for number in _compared_numbers(side)})
    if numbers:
        *before, last = map(str, numbers)
        listed = f"Maps {', '.join(before)} and {last}" if before else f"Map {last}"
        of_paper = ", as in the paper's figure" if tuple(numbers) == COMPARED_MAPS else ""
        parts.insert(0, caption(f"<b>{listed}</b>{of_paper}"))
    for number in numbers:
        for side in frame.sides:
            maps = side.run.maps
            if maps is not None and number in _compared_numbers(side):
                title = f"{method_span(side.run.method, frame.state.dark)} map {number}"
                clicked = ("compared", side.pane)
                parts.append(heatmap_html(maps, number, side.map_order, title, side.marked, clicked))
    return "".join(parts)


def _compared_numbers(side: SideFrame) -> set[int]:
    """Of the maps that are compared, those that a method has, and its last."""
    count = 0 if side.run.maps is None else len(side.run.maps.maps)
    return {min(number, count) for number in COMPARED_MAPS} - {0}


def heatmap_html(
    maps: Maps, number: int, order: np.ndarray, title: str, marked: int = NO_POINT, clicked: tuple[str, int] = ("", 0)
) -> str:
    """A map as a picture with named rows and blocks; `title` is HTML.

    Args:
        maps: the maps.
        number: of the map, from 1.
        order: of the bins, from left to right.
        title: HTML.
        marked: number of a model point whose bins are marked.
        clicked: kind and pane of a click into it, as `picking.Click` has them.
    """
    source, scale = _picture(maps, number, order.tobytes())
    rows = "".join(f'<div style="height:{_ROW}px">{name}</div>' for name in PARAMETERS)
    names = "".join(
        f'<div style="flex:1;text-align:center;border-top:3px solid {palette.css(palette.block_color(block, i))};'
        f'overflow:hidden;text-overflow:ellipsis">{html.escape(short_side(side))}</div>'
        for i, block in enumerate(maps.histogram.blocks)
        for side in block.sides
    )
    return (
        caption(f'{title}<span style="float:right">-{scale:.2g} {_KEY} {scale:.2g}</span>')
        + f'<div style="display:flex;margin:2px 8px 0 8px;font-size:0.625rem;line-height:{_ROW}px">'
        f'<div style="width:20px">{rows}</div><div data-heatmap="{clicked[0]}" data-pane="{clicked[1]}" '
        'style="position:relative;width:calc(100% - 20px);cursor:pointer">'
        f'<img alt="heatmap of the map" src="{source}" style="width:100%;height:{6 * _ROW}px;display:block">'
        f"{_marks(order, len(maps.histogram.model.points), marked)}</div></div>"
        f'<div style="display:flex;margin:1px 8px 4px 28px;font-size:0.625rem;line-height:1.2">{names}</div>'
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
    picture = Image.fromarray(np.repeat(palette.diverging_levels(values, scale), _ROW, axis=0))
    picture.putpalette(palette.DIVERGING.tobytes())
    return png_address(picture), scale


def png_address(picture: Image.Image) -> str:
    """A picture as the data address of a PNG."""
    stream = io.BytesIO()
    picture.save(stream, format="PNG", compress_level=6)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()
