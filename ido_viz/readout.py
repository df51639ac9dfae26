"""The live numbers of both panes, as HTML."""

from __future__ import annotations

import html

import numpy as np

from ido_viz import palette
from ido_viz.run import MethodRun, Run, norms


def readout_html(run: Run, iteration: int) -> str:
    """A table of both sides' live numbers, and below it where a side failed, if one did."""
    rows: list[tuple[str, list[str]]] = [
        ("Iteration", []),
        ("Next update", []),
        ("PointAcc", []),
        ("PointRMSE", []),
        ("Rotation error", []),
        ("Translation error", []),
        ("Stops", []),
    ]
    for side in run.sides:
        k, n = side.clipped(iteration), side.trajectory.iterations
        norm = "–" if np.isnan(norms(side)[k]) else f"{norms(side)[k]:.4f}"
        scores = side.scores
        cells = [f"{k} / {n}", norm, f"{scores.accuracy[k]:.3f}", f"{scores.rmse[k]:.4f}"]
        cells += [f"{scores.rotation[k]:.2f}°", f"{scores.translation[k]:.4f}", verdict(side, k)]
        for row, cell in zip(rows, cells, strict=True):
            row[1].append(cell)
    head = "".join(
        f'<th style="text-align:right;color:{palette.css(palette.METHODS[i])}">{html.escape(side.method)}</th>'
        for i, side in enumerate(run.sides)
    )
    body = "".join(
        f"<tr><td>{name}</td>" + "".join(f'<td style="text-align:right">{cell}</td>' for cell in cells) + "</tr>"
        for name, cells in rows
    )
    return (
        '<table class="readout" style="width:calc(100% - 22px);margin:0 14px 0 8px;font-size:0.75rem;line-height:1.35;'
        f'font-variant-numeric:tabular-nums"><tr><th></th>{head}</tr>{body}</table>'
        + _LEGEND
        + "".join(map(trace_html, range(2), run.sides))
    )


def trace_html(number: int, side: MethodRun) -> str:
    """The traceback of a side that failed, in a box that scrolls and begins at its end; nothing for one that did not.

    Args:
        number: of the side, 0 for the left one.
        side: its run.
    """
    if not side.trace:
        return ""
    color = palette.css(palette.METHODS[number])
    return (
        f'<div style="margin:6px 8px 0 8px;font-size:0.6875rem"><b style="color:{color}">{html.escape(side.method)}</b>'
        ' failed:</div><div class="trace" tabindex="0" style="display:flex;flex-direction:column-reverse;overflow:auto;'
        f"max-height:14rem;margin:2px 8px 6px 8px;padding:4px;border-left:3px solid {color};"
        f'background:rgba(128,128,128,.12)"><pre style="margin:0;font:0.625rem/1.35 monospace;white-space:pre-wrap;'
        f'overflow-wrap:anywhere">{html.escape(side.trace)}</pre></div>'
    )


def verdict(side: MethodRun, k: int) -> str:
    """Why a method stopped, and whether where the scene belongs; nothing of it before the end."""
    if side.waiting:
        return html.escape(side.waiting)
    if k < side.trajectory.iterations:
        return "moving"
    accuracy = side.scores.accuracy[k]
    place = "in place" if accuracy >= _IN_PLACE else "nearly in place" if accuracy >= _NEARLY else "wrong pose"
    return f"{side.trajectory.stop}, {place}"


_IN_PLACE, _NEARLY = 0.95, 0.5  # PointAcc
_LEGEND = (
    '<div style="margin:4px 8px 0 8px;font-size:0.6875rem">'
    + " &nbsp;".join(
        '<span style="white-space:nowrap">'
        + "".join(f'<span style="color:{palette.css(color)}">●</span>' for color in colors)
        + f" {name}</span>"
        for name, colors in (
            ("model", ((128, 128, 128),)),
            ("scene", palette.METHODS),
            ("outliers", (palette.OUTLIER,)),
            ("where it belongs", (palette.GHOST,)),
        )
    )
    + "</div>"
)
