"""The slow motion of one iteration, drawn over the canvas: a sentence and a picture for each of its five beats."""

from __future__ import annotations

import html

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from ido import poses
from ido.poses import PARAMETERS
from ido_viz.core import palette
from ido_viz.core.frame import Frame
from ido_viz.core.inside import Inside
from ido_viz.core.state import BEATS
from ido_viz.core.wording import one_line, short_side

_WIDTH, _HEIGHT = 560, 128  # of a picture, in its own units
_NORMAL, _LARGE = 13, 18  # of the words in it
_DOTS = 500  # of a histogram, at most
_STYLE = """<style>
.inside { position: fixed; position-anchor: --canvas; left: 26%; right: 31%; bottom: 1.9rem; z-index: 6;
  border-radius: 6px; padding: 0.4rem 0.8rem; pointer-events: none; }
@supports (left: anchor(left)) { .inside { left: calc(anchor(left) + 0.8rem); right: calc(anchor(right) + 0.8rem);
  bottom: calc(anchor(bottom) + 1.9rem); } }
.inside svg { width: 100%; max-height: 7.4rem; display: block; }
.inside .sentence { font-size: 0.95rem; line-height: 1.35; height: 3.85rem; overflow: hidden; }
@media (max-width: 600px) { .inside { left: 0; right: 0; bottom: auto; top: 8rem; } }
</style>"""


class InsidePanel:
    """Draws the slow motion of one page."""

    def __init__(self, gui: viser.GuiApi) -> None:
        gui.add_html(_STYLE)
        self._html = gui.add_html("")

    def draw(self, frame: Frame) -> None:
        """Draw the beat of a frame; nothing where none is shown."""
        content = (
            "" if frame.inside is None else inside_html(frame.inside, frame.state.dark, large=frame.state.large_text)
        )
        if self._html.content != content:
            self._html.content = content


def inside_html(inside: Inside, dark: bool, *, large: bool = False) -> str:
    """A beat as HTML."""
    ink, page = palette.css(palette.ink(dark)), palette.css(palette.PAGES[dark], 0.9)
    dots = "".join("●" if number <= inside.beat else "○" for number in range(1, BEATS + 1))
    sentence, picture = _BEATS[inside.beat - 1](inside, dark)
    return (
        f'<div class="inside" style="background:{page};color:{ink};border:1px solid {palette.css(palette.GUIDE, 0.4)}">'
        f'<div class="sentence"><span aria-label="beat {inside.beat} of {BEATS}">{dots}</span> '
        f"<b>{html.escape(one_line(inside.inspection.side.method))}:</b> {sentence}</div>"
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="beat {inside.beat}" fill="{ink}" '
        f'font-size="{_LARGE if large else _NORMAL}" font-family="sans-serif">{picture}</svg></div>'
    )


def _asks(inside: Inside, dark: bool) -> tuple[str, str]:
    first, counts = inside.asked
    color = _block_color(inside)
    some = np.flatnonzero(counts > 0.01)
    picture = "".join(
        f'<circle cx="24" cy="{y}" r="14" fill="{fill}"/><text x="50" y="{y + 5}">{html.escape(name)}: '
        f"{int((first[some] == is_first).sum())} points that count</text>"
        for y, fill, name, is_first in (
            (22, color, inside.question.first, True),
            (60, palette.css(palette.ink(dark)), inside.question.second, False),
        )
    )
    questions = inside.inspection.side.histogram.questions
    which = f", question {questions.index(inside.question) + 1} of {len(questions)}" if len(questions) > 1 else ""
    return (
        f"One model point, the yellow one (number {inside.point}), asks every scene point{which}: "
        f"<b>{html.escape(inside.question.first)}</b> or <b>{html.escape(inside.question.second)}</b>?",
        f'{picture}<text x="10" y="104">{_how_they_count(inside)}</text>',
    )


def _how_they_count(inside: Inside) -> str:
    counts = inside.counts
    if np.ptp(counts) == 0:
        return "Every point counts the same, near or far."
    if (np.diff(counts) <= 1e-9).all():
        return "The nearer a point is, the more it counts, and the stronger its colour."
    return "The more a point counts, the stronger its colour."


def _fills(inside: Inside, dark: bool) -> tuple[str, str]:
    seen, reference = inside.inspection.seen, inside.inspection.side.histogram.reference
    most = max(*(seen[j] for j in inside.bins), *(reference[j] for j in inside.bins), 1e-9)
    rows = []
    for row, (name, j, fill) in enumerate(
        (
            (inside.question.first, inside.bins[0], _block_color(inside)),
            (inside.question.second, inside.bins[1], palette.css(palette.ink(dark))),
        )
    ):
        y, long = 14 + 52 * row, 330 / most
        mark = 130 + long * reference[j]
        rows.append(
            f'<text x="4" y="{y + 22}">{html.escape(name)}</text>'
            f'<rect x="130" y="{y}" width="{long * seen[j] * inside.share:.1f}" height="32" fill="{fill}"/>'
            f'<line x1="{mark:.1f}" x2="{mark:.1f}" y1="{y - 6}" y2="{y + 38}" '
            f'stroke="{palette.css(palette.GHOST)}" stroke-width="3"/>'
            f'<text x="470" y="{y + 22}">{seen[j]:.3f}</text>'
        )
    sentence = (
        "What they count is added up: two <b>bins</b> fill. The green marks are the <b>reference</b>: what this model "
        "point sees of a scene in its place."
    )
    return sentence, "".join(rows)


def _stands(inside: Inside, dark: bool) -> tuple[str, str]:
    histogram, seen = inside.inspection.side.histogram, inside.inspection.seen
    order = np.argsort(histogram.reference.reshape(len(histogram.side_names), -1), axis=1, kind="stable")
    order = (order + np.arange(len(order))[:, None] * order.shape[1]).ravel()
    chosen = order[:: max(1, len(order) // _DOTS)]
    top = max(float(np.quantile(seen, 0.995)), float(histogram.reference.max()), 1e-9)
    x = np.linspace(4, _WIDTH - 4, len(chosen))

    def y(values: np.ndarray) -> np.ndarray:
        return _HEIGHT - 16 - (_HEIGHT - 22) * np.minimum(values / top, 1.0)

    shown = int(np.ceil(inside.share * len(chosen)))
    block_of = chosen // (histogram.n_bins // len(histogram.blocks))
    places = np.stack([x, y(seen[chosen])], axis=1)
    dots = "".join(
        f'<path d="{"".join(f"M{a:.1f} {b:.1f}h.01" for a, b in places[:shown][block_of[:shown] == number])}" '
        f'stroke="{palette.css(palette.block_color(block, number))}" stroke-width="3" stroke-linecap="round"/>'
        for number, block in enumerate(histogram.blocks)
    )
    line = "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y(histogram.reference[chosen]), strict=True))
    names, wide = histogram.side_names, (_WIDTH - 8) / len(histogram.side_names)
    labels = "".join(
        f'<text x="{4 + (i + 0.5) * wide:.0f}" y="{_HEIGHT - 2}" text-anchor="middle">{html.escape(name)}</text>'
        for i, name in enumerate(map(short_side, names))
    )
    return (
        f"All {histogram.n_bins} bins, as dots, against the <b>reference line</b>. In the right place they would lie "
        "on it.",
        f'{dots}<path d="{line}" fill="none" stroke="{palette.css(palette.ink(dark))}"/>{labels}',
    )


def _weighs(inside: Inside, dark: bool) -> tuple[str, str]:
    side, shares = inside.inspection.side, inside.inspection.shares
    of_blocks = shares.of_blocks * inside.share
    reach = max(float(np.abs(shares.of_blocks).sum(axis=1).max()), 1e-9)
    middle, long = 270, 190 / reach
    parts = [f'<line x1="{middle}" x2="{middle}" y1="2" y2="{_HEIGHT - 4}" stroke="{palette.css(palette.GUIDE)}"/>']
    for row, name in enumerate(PARAMETERS):
        y, ends = 4 + 20 * row, [0.0, 0.0]
        parts.append(f'<text x="40" y="{y + 13}">{name}</text>')
        for number, (block, value) in enumerate(zip(side.histogram.blocks, of_blocks[row], strict=True)):
            way = int(value > 0)
            start, ends[way] = ends[way], ends[way] + float(value)
            left = middle + long * min(start, ends[way])
            color = palette.css(palette.block_color(block, number))
            parts.append(f'<rect x="{left:.1f}" y="{y}" width="{long * abs(value):.1f}" height="15" fill="{color}"/>')
        parts.append(f'<text x="480" y="{y + 13}">{shares.update[row] * inside.share:+.4f}</text>')
    blocks = " ".join(
        f'<span style="color:{palette.css(palette.text(palette.block_color(block, i), dark))}">■ '
        f"{html.escape(block.name)}</span>"
        for i, block in enumerate(side.histogram.blocks)
    )
    return f"<b>Map {inside.map_number}</b> weighs every bin and adds them up to six numbers. {blocks}", "".join(parts)


def _moves(inside: Inside, dark: bool) -> tuple[str, str]:
    step = inside.T_next @ poses.invert(inside.T_now)
    degrees = float(np.rad2deg(Rotation.from_matrix(step[:3, :3]).magnitude()))
    update = inside.inspection.shares.update
    numbers = "".join(
        f'<text x="{40 + 170 * (i % 3)}" y="{34 + 44 * (i // 3)}" font-size="18">{name} {value:+.4f}</text>'
        for i, (name, value) in enumerate(zip(PARAMETERS, update, strict=True))
    )
    return (
        f"Three of them shift the cloud, three turn it, here by <b>{degrees:.1f}°</b>: the arrow and the arc. Then it "
        "moves. That was one iteration.",
        numbers,
    )


def _block_color(inside: Inside) -> str:
    blocks = inside.inspection.side.histogram.blocks
    return palette.css(palette.block_color(inside.question, blocks.index(inside.question)))


_BEATS = (_asks, _fills, _stands, _weighs, _moves)
