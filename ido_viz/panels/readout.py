"""The live numbers of both panes, as HTML."""

from __future__ import annotations

import html

import numpy as np

from ido_viz.core import palette
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.run import MethodRun

ROWS = (
    "Iteration",
    "Next update",
    "PointAcc",
    "PointRMSE",
    "Rotation error",
    "Translation error",
    "Stops",
)


def readout_html(frame: Frame) -> str:
    """A table of both sides' live numbers, and below it where a side failed, if one did."""
    head = "".join(
        f'<th style="text-align:right;color:{_color(side.run.method, frame.state.dark)}">'
        f"{html.escape(side.run.method)}</th>"
        for side in frame.sides
    )
    body = "".join(
        f'<tr><td style="white-space:nowrap">{name}</td>'
        + "".join(f'<td style="text-align:right">{html.escape(cell)}</td>' for cell in cells)
        + "</tr>"
        for name, *cells in zip(ROWS, *map(_cells, frame.sides), strict=True)
    )
    return (
        '<table class="readout" style="width:calc(100% - 22px);margin:0 14px 0.3rem 8px;font-size:0.75rem;'
        'line-height:1.35;table-layout:fixed;overflow-wrap:anywhere;font-variant-numeric:tabular-nums">'
        f'<tr><th style="width:36%"></th>{head}</tr>{body}</table>'
        + "".join(trace_html(side.run, frame.state.dark) for side in frame.sides)
    )


def _color(method: str, dark: bool) -> str:
    return palette.css(palette.text(palette.method_color(method, dark), dark))


def _cells(side: SideFrame) -> tuple[str, ...]:
    """What is told of a side, in the order of `ROWS`."""
    scores, k = side.run.scores, side.k
    return (
        f"{k} / {side.run.trajectory.iterations}",
        "–" if np.isnan(side.next_norm) else f"{side.next_norm:.4f}",
        f"{side.accuracy:.3f}",
        f"{side.rmse:.4f}",
        f"{scores.rotation[k]:.2f}°",
        f"{scores.translation[k]:.4f}",
        side.caption.stop,
    )


def trace_html(side: MethodRun, dark: bool) -> str:
    """The traceback of a side that failed, in a box that scrolls and begins at its end; nothing for one that did not.

    Args:
        side: its run.
        dark: whether the page is.
    """
    if not side.trace:
        return ""
    color = _color(side.method, dark)
    return (
        f'<div style="margin:6px 8px 0 8px;font-size:0.6875rem"><b style="color:{color}">{html.escape(side.method)}</b>'
        " failed. Code is read when the explorer starts: mend it, then start it again.</div>"
        '<div class="trace" tabindex="0" style="display:flex;flex-direction:column-reverse;overflow:auto;'
        f"max-height:14rem;margin:2px 8px 6px 8px;padding:4px;border-left:3px solid {color};"
        f'background:rgba(128,128,128,.12)"><pre style="margin:0;font:0.625rem/1.35 monospace;white-space:pre-wrap;'
        f'overflow-wrap:anywhere">{html.escape(side.trace)}</pre></div>'
    )
