"""What is written over the canvas: each pane's method above it, below how sure it is and its verdict, and a legend."""

from __future__ import annotations

import html

import viser

from ido_viz.core import palette
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.legend import legend_html
from ido_viz.core.verdict import Verdict
from ido_viz.core.wording import one_line
from ido_viz.panels.sureness import sureness_html

_SIGNS = {
    Verdict.IN_PLACE: "✓",
    Verdict.NEARLY_IN_PLACE: "≈",
    Verdict.WRONG_POSE: "✗",
    Verdict.FAILED: "✗",
    Verdict.STARTING: "→",
    Verdict.MOVING: "→",
    Verdict.COMPUTING: "…",
    Verdict.CANCELLED: "–",
}

_OPENING = (
    "Each method moves the coloured scene, step by step, onto the grey model.<br>"
    '<span class="invitation">Drag a slider, or an arrow or ring at a scene, to make it harder.</span>'
)

# The canvas is an anchor, so that what is written stays on it whatever is docked beside it; where a browser knows no
# anchors, it lies over the window's middle. Heights are fixed: nothing moves when a text changes.
_STYLE = """<style>
canvas[data-engine] { anchor-name: --canvas; }
.over-canvas { position: fixed; position-anchor: --canvas; left: 25%; right: 30%; z-index: 5; pointer-events: none;
  display: flex; overflow: hidden;
  text-shadow: 0 0 0.2em var(--mantine-color-body), 0 0 0.4em var(--mantine-color-body); }
@supports (left: anchor(left)) { .over-canvas { left: anchor(left); right: anchor(right); } }
.names { top: 0.6rem; height: 3.4rem; }
.opening { top: 4.2rem; height: 3.4rem; }
.verdicts { bottom: 1.9rem; height: 4.1rem; }
.sureness { bottom: 5.9rem; height: 6rem; align-items: flex-end; }
.legend { bottom: 0.5rem; height: 1.2rem; justify-content: center; }
@supports (left: anchor(left)) {
  .names { top: calc(anchor(top) + 0.6rem); }
  .opening { top: calc(anchor(top) + 4.2rem); }
  .verdicts { bottom: calc(anchor(bottom) + 1.9rem); }
  .sureness { bottom: calc(anchor(bottom) + 5.9rem); }
  .legend { bottom: calc(anchor(bottom) + 0.5rem); }
}
.over-canvas > div { flex: 1 1 0; min-width: 0; text-align: center; line-height: 1.35; padding: 0 0.4rem;
  white-space: nowrap; overflow: hidden; text-overflow: ellipsis; }
.over-canvas.sureness > div, .over-canvas.opening > div { white-space: normal; }
body:has(.lesson) .opening { display: none; }
body:has(.lesson) .verdicts { bottom: auto; top: 4rem; }
[data-dock-group]:has(.lesson) { anchor-name: --lesson; }
body:has(.lesson) .legend { bottom: calc(anchor(--lesson top, 0rem) + 0.5rem); }
body:has(.lesson) .sureness { bottom: auto; top: 7.6rem; align-items: flex-start; }
@media (max-width: 600px) {
  .over-canvas { left: 0; right: 0; }
  .invitation { display: none; }
  .verdicts { bottom: auto; top: calc(40vh - 4.4rem); }
  .sureness { bottom: auto; top: 4rem; align-items: flex-start; }
  .legend { display: none; }
}
</style>"""


class Captions:
    """Writes over the canvas of one page."""

    def __init__(self, gui: viser.GuiApi) -> None:
        gui.add_html(_STYLE)
        self._html = gui.add_html("")

    def draw(self, frame: Frame) -> None:
        """Write what a frame says of both panes."""
        content = captions_html(frame)
        if self._html.content != content:
            self._html.content = content


def captions_html(frame: Frame) -> str:
    """Names, verdicts and the meaning of the colours, as HTML."""
    names = "".join(f"<div>{_name_html(side, frame)}</div>" for side in frame.sides)
    verdicts = "".join(f'<div class="verdict">{_verdict_html(side, frame)}</div>' for side in frame.sides)
    sureness = "".join(f'<div class="sure">{sureness_html(side, frame)}</div>' for side in frame.sides)
    return (
        f'<div class="over-canvas names">{names}</div>{_opening_html(frame)}'
        f'<div class="over-canvas verdicts">{verdicts}</div>'
        f'<div class="over-canvas sureness">{sureness}</div>'
        f'<div class="over-canvas legend">{legend_html(frame)}</div>'
    )


def _opening_html(frame: Frame) -> str:
    """What is about to happen, as long as nothing has."""
    starting = all(side.verdict is Verdict.STARTING for side in frame.sides)
    if not starting or frame.held or frame.inside is not None:
        return ""
    ink = palette.css(palette.ink(frame.state.dark))
    return f'<div class="over-canvas opening"><div style="font-size:0.9rem;color:{ink}">{_OPENING}</div></div>'


def _name_html(side: SideFrame, frame: Frame) -> str:
    dark = frame.state.dark
    color = palette.css(palette.text(palette.method_color(side.run.method, dark), dark))
    written = side.caption.progress
    if side.caption.overlay:  # there is little room
        written = f"{written.removeprefix('iteration ')}, {side.caption.overlay}"
    return (
        f'<b style="font-size:1.15rem;color:{color}">{html.escape(one_line(side.caption.method))}</b><br>'
        f'<span style="font-size:0.8rem;color:{palette.css(palette.ink(dark))}">'
        f"{html.escape(written)}</span>"
    )


def _verdict_html(side: SideFrame, frame: Frame) -> str:
    """The verdict, large, and the reason for it; while the start is in somebody's hand, that of the end."""
    dark = frame.state.dark
    if "scores" in frame.state.hidden or frame.inside is not None:  # the slow motion has the place
        return ""
    verdict = side.run.verdict(side.run.trajectory.iterations) if frame.held else side.verdict
    color = palette.css(palette.text(palette.verdict_color(verdict), dark))
    words = verdict.foretold if frame.held and side.run.pending is None else str(verdict)
    size = 1.15 if frame.held else 1.5  # rem; what will be takes more words
    return (
        f'<b style="font-size:min({size}rem,5vw);color:{color}">{_SIGNS[verdict]} {words}</b><br>'
        f'<span style="font-size:0.8rem;color:{palette.css(palette.ink(dark))}">'
        f"{html.escape(_reason(side, verdict, frame.held))}</span>"
    )


def _reason(side: SideFrame, verdict: Verdict, held: bool) -> str:
    """Why that is said."""
    if side.run.pending is not None:
        return one_line(side.run.waiting)
    k = side.run.trajectory.iterations if held else side.k
    arrived = f"{side.run.scores.accuracy[k]:.0%} arrived"
    if verdict.is_open:
        return arrived
    away = "" if verdict is Verdict.IN_PLACE else f", {side.run.scores.rotation[k]:.0f}° off"
    return f"{arrived}{away} · {side.run.trajectory.stop}"
