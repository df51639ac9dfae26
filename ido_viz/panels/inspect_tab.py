"""The tab Inspect: why one pane's method moves: its strongest bins, its blocks, and one model point."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Any, get_args

import numpy as np
import viser

from ido.attribution import bin_name
from ido.poses import PARAMETERS
from ido_viz.core.actions import at_once
from ido_viz.core.frame import Frame
from ido_viz.core.inspection import Inspection
from ido_viz.core.state import NO_POINT, Coloring, Pane, State
from ido_viz.panels.markup import caption, method_span, signed, table_html

NO_BIN = "choose one"
"""Stands first in the list of bins, so that the strongest one can be chosen, too."""

_NO_SHARES = "The steps of this method are not sums over the bins of a histogram, so no bin has a share in them."

Change = Callable[[dict[str, Any]], None]
"""Called with the fields of the state that a person changed."""


class InspectTab:
    """The widgets and tables of one page."""

    def __init__(self, gui: viser.GuiApi, state: State, change: Change) -> None:
        self._inputs: dict[str, Any] = {
            "inspected_pane": gui.add_dropdown(
                "Look into the", get_args(Pane), initial_value=state.inspected_pane, hint="The method of this pane."
            ),
            "coloring": gui.add_dropdown(
                "Model colours",
                get_args(Coloring),
                initial_value=state.coloring,
                hint="Colour each model point by its share in the next update, in what of it leads to the true pose, "
                "or in one of its six numbers. Blue takes away, red adds.",
            ),
            "against_reference": gui.add_checkbox(
                "Against the reference",
                state.against_reference,
                hint="Shares of what differs from the reference line alone.",
            ),
            "inspected": gui.add_number(
                "Model point",
                state.inspected,
                min=NO_POINT,
                step=1,
                hint="Its number, or click a grey point of the model in the 3D view; -1 for none.",
            ),
            "scene_point": gui.add_number(
                "Scene point",
                state.scene_point,
                min=NO_POINT,
                step=1,
                hint="Ask the model point about this one scene point alone; -1 for all of them.",
            ),
            "question": gui.add_dropdown(
                "Its question",
                (state.question,),
                initial_value=state.question,
                hint="Colours the scene points by the model point's answer, paler where they count less.",
            ),
        }
        for name, handle in self._inputs.items():
            handle.on_update(at_once(lambda value, name=name: change({name: value})))
        self._bins: Any = gui.add_dropdown(
            "Strongest bins",
            (NO_BIN,),
            initial_value=NO_BIN,
            hint="Choose one to look into its model point. With the model's colours towards the truth, these are the "
            "bins that lead astray most.",
        )
        self._bins.on_update(at_once(lambda text: self._choose(text, change)))
        self._sort = gui.add_dropdown(
            "List by", tuple(LISTED_BY), initial_value="share", hint="How the list of the strongest bins is sorted."
        )
        self._sort.on_update(lambda event: change({}) if event.client else None)
        self._tables = gui.add_html("")

    def _choose(self, text: str, change: Change) -> None:
        if text != NO_BIN:
            change({"inspected": int(text.split()[0])})

    def draw(self, frame: Frame) -> None:
        """Draw the tables, and write the state into the widgets where it differs."""
        state, inspection = frame.state, frame.inspected.inspection
        asked = (block.name for block in frame.inspected.run.histogram.questions)
        questions = tuple(dict.fromkeys((*asked, state.question)))
        if self._inputs["question"].options != questions:
            self._inputs["question"].options = questions
        for name, handle in self._inputs.items():
            if handle.value != getattr(state, name):
                handle.value = getattr(state, name)
        if inspection is None:
            content, bins = caption(_NO_SHARES), ()
        else:
            content = bins_html(inspection, self._sort.value) + tables_html(inspection, state)  # below its sorting
            bins = tuple(bin_label(inspection, int(number)) for number in inspection.strongest)
        if self._tables.content != content:
            self._tables.content = content
        if self._bins.options != (NO_BIN, *bins) and not state.playing:  # a list that is in use must not change
            self._bins.options = (NO_BIN, *bins)


def bin_label(inspection: Inspection, number: int) -> str:
    """A bin by its model point, side and share."""
    side, point = bin_name(inspection.side.histogram, number)
    return f"{point} {side} {signed(inspection.values[number], 4)}"


def tables_html(inspection: Inspection, state: State) -> str:
    """The shares of the blocks, and the bins of the inspected point."""
    side, shares = inspection.side, inspection.shares
    what = _WHAT.get(state.coloring, state.coloring)
    title = f"<b>{method_span(side.method, state.dark)}</b> next update, by blocks"
    blocks = [
        (block.name, value, *(signed(value, 3) for value in of_block))
        for block, value, of_block in zip(
            side.histogram.blocks,
            (signed(of, 4) for of in inspection.values.reshape(len(side.histogram.blocks), -1).sum(axis=1)),
            shares.of_blocks.T,
            strict=True,
        )
    ]
    rows = [*blocks, ("all", signed(inspection.values.sum(), 4), *(signed(value, 3) for value in shares.update))]
    head = ("", what, *PARAMETERS)
    if what in PARAMETERS:  # it has a column already
        head, rows = ("", *PARAMETERS), [(name, *values) for name, _, *values in rows]
    parts = [caption(title), table_html(head, rows, marked=what if state.coloring != "height" else "")]
    if inspection.point is not None:
        parts += [caption(f"model point {inspection.point}"), point_table(inspection, what)]
        if inspection.scene_point is not None:
            parts.append(pair_table(inspection))
    else:
        parts.append(caption("Click a point of the model in the 3D view to see its bins."))
    return "".join(parts)


LISTED_BY: dict[str, Callable[[Inspection, int], float]] = {
    "share": lambda inspection, j: -abs(inspection.values[j]),
    "bin": lambda inspection, j: -inspection.seen[j],
    "off the reference": lambda inspection, j: -abs(inspection.seen[j] - inspection.side.histogram.reference[j]),
    "model point": lambda inspection, j: j % len(inspection.side.histogram.model.points),
}
"""What the list of the strongest bins can be sorted by, and the key of it."""


def bins_html(inspection: Inspection, by: str) -> str:
    """The strongest bins as a table; a click on a row picks its bin."""
    histogram = inspection.side.histogram
    rows = []
    for number in sorted(map(int, inspection.strongest), key=lambda j: LISTED_BY[by](inspection, j)):
        side, point = bin_name(histogram, number)
        cells = (f"{inspection.seen[number]:.4f}", f"{histogram.reference[number]:.4f}")
        picked = "background:rgba(240,228,66,.35);" if point == inspection.point else ""
        rows.append(
            f'<tr data-bin="{number}" data-pane="{inspection.pane}" style="cursor:pointer;{picked}">'
            f"<td>{point} {html.escape(side)}</td>"
            + "".join(f'<td style="text-align:right">{c}</td>' for c in (*cells, signed(inspection.values[number], 4)))
            + "</tr>"
        )
    head = "".join(
        f'<th style="text-align:{"left" if i == 0 else "right"}">{name}</th>'
        for i, name in enumerate(("strongest bins: click one", "bin", "reference", "share"))
    )
    return (
        '<table class="bins" style="width:calc(100% - 16px);margin:8px 8px 6px 8px;font-size:0.7rem;line-height:1.5;'
        f'font-variant-numeric:tabular-nums;border-collapse:collapse"><tr>{head}</tr>{"".join(rows)}</table>'
    )


_WHAT = {"height": "along it", "whole update": "along it", "towards the truth": "right way"}


def pair_table(inspection: Inspection) -> str:
    """What the inspected model point says of the one scene point: its answer, the weight, and the share in the bin."""
    histogram, point, one = inspection.side.histogram, inspection.point, inspection.scene_point
    assert point is not None and one is not None
    rows = []
    for question in histogram.questions:
        first, counts = question.of_point(histogram.model, point, inspection.moved)
        total = counts[first == first[one]].sum()
        answer = question.first if first[one] else question.second
        rows.append((question.name, answer, f"{counts[one]:.4f}", f"{counts[one] / total if total > 0 else 0.0:.2%}"))
    distance = float(np.linalg.norm(inspection.moved[one] - histogram.model.points[point]))
    rows.append(("its distance", "", f"{distance:.3f}", ""))
    return table_html((f"asked about scene point {one}", "answer", "weight", "share of the bin"), rows)


def point_table(inspection: Inspection, what: str) -> str:
    """The bins of the inspected point: what they hold, what the reference holds, the weight, and the share."""
    histogram, point = inspection.side.histogram, inspection.point
    assert point is not None
    n_model = len(histogram.model.points)
    names = histogram.side_names
    weights = getattr(histogram, "weights", np.ones((len(names), n_model)))
    rows = [
        (
            name,
            f"{inspection.seen[i * n_model + point]:.4f}",
            f"{histogram.reference[i * n_model + point]:.4f}",
            f"{weights[i, point]:.2f}",
            f"{inspection.values[i * n_model + point]:+.5f}",
        )
        for i, name in enumerate(names)
    ]
    return table_html(("side", "bin", "reference", "weight", f"share {what}"), rows)
