"""How sure a method from any start is of its pose, large, and why it may be wrong: what is known without the truth."""

from __future__ import annotations

import html

from ido.global_registration import Confidence
from ido.global_registration.confidence import SURE
from ido_viz.core import palette
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.verdict import Verdict

_VERY_SURE = 0.95
_MOST_REASONS = 2  # there is room for
_DISAGREEING = "the verdict knows the true place, this does not"


def sureness_html(side: SideFrame, frame: Frame) -> str:
    """The probability that a pane's pose is right, with the first reasons for doubt; nothing before the end."""
    sure, dark = side.run.confidence, frame.state.dark
    ended = frame.held or not side.verdict.is_open
    if sure is None or not ended or frame.inside is not None or "scores" in frame.state.hidden:
        return ""
    color = palette.css(palette.text(palette.verdict_color(_like(sure)), dark))
    verdict = side.run.verdict(side.run.trajectory.iterations)
    lines = ["; ".join(sure.reasons[:_MOST_REASONS]) or "without knowing the truth"]
    if (sure.probability >= SURE) != (verdict is Verdict.IN_PLACE):
        lines.append(_DISAGREEING)
    return (
        f'<b style="font-size:1.5rem;color:{color}">{percent(sure.probability)} sure</b>'
        f'<div style="font-size:0.75rem;color:{palette.css(palette.ink(dark))}">'
        f"{'<br>'.join(map(html.escape, lines))}</div>"
    )


def percent(probability: float) -> str:
    """A probability in whole percent, which says neither never nor always."""
    return f"{min(max(round(100 * probability), 1), 99)}%"


def _like(sure: Confidence) -> Verdict:
    """The verdict whose colour fits."""
    if sure.probability >= _VERY_SURE:
        return Verdict.IN_PLACE
    return Verdict.NEARLY_IN_PLACE if sure.probability >= SURE else Verdict.WRONG_POSE
