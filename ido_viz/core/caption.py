"""What is written of one side of a frame, in plain words: the canvas, the panels and the files draw the same."""

from __future__ import annotations

from dataclasses import dataclass

from ido_viz.core.overlay import Overlay
from ido_viz.core.run import MethodRun
from ido_viz.core.state import State
from ido_viz.core.verdict import Verdict


@dataclass(frozen=True, slots=True)
class Caption:
    """What is written of a method at one of its poses.

    Args:
        method: its name.
        progress: how far it is, with how many of its starts, or why it is not there yet.
        overlay: what is laid over it, as ``with ...``; empty for nothing.
        scores: PointRMSE and PointAcc; none where a lecturer hides them.
        stop: why it stopped; nothing of it before the end.
    """

    method: str
    progress: str
    overlay: str
    scores: tuple[str, ...]
    stop: str


def caption_of(side: MethodRun, k: int, overlay: Overlay | None, verdict: Verdict, state: State) -> Caption:
    """What is written of a method after k of its iterations."""
    starts = "" if side.race is None else f", {side.race.left(k)} starts"
    told = "scores" not in state.hidden
    return Caption(
        method=side.method,
        progress=side.waiting or f"iteration {k} of {side.trajectory.iterations}{starts}",
        overlay="" if overlay is None else f"with {overlay.title}",
        scores=(f"PointRMSE {side.scores.rmse[k]:.3f}", f"PointAcc {side.scores.accuracy[k]:.2f}") if told else (),
        stop=side.waiting or ("not yet" if verdict.is_open else str(side.trajectory.stop)),
    )
