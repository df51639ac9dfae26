"""The charts of a page as an archive for a paper: each as SVG and PNG, and a text that says what they show."""

from __future__ import annotations

import io
import threading
import zipfile

import matplotlib
from matplotlib.figure import Figure

from ido_viz.captions import scene_line, shown_iteration
from ido_viz.figures import DOTS_PER_INCH, STYLE, WIDTH, curves_figure, histograms_figure, maps_figure, one_line
from ido_viz.run import MethodRun, Run
from ido_viz.state import State, encode

_drawing = threading.Lock()  # Matplotlib's settings are everybody's


def charts_zip(run: Run, state: State) -> bytes:
    """The charts of a state as an archive: each as .svg and .png, and a README.txt that says what they show.

    Figures are `WIDTH` inches wide, on white whether the page is dark or not; text in the SVGs is text. Where neither
    method has maps there is no figure of them. The same state gives the same bytes.
    """
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as members:

        def add(name: str, content: bytes) -> None:
            members.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)

        with _drawing, matplotlib.rc_context(STYLE):
            for name, figure in _figures(run, state).items():
                about = {"Title": f"{name}: {_names(run)}", "Description": f"{scene_line(state)}; {encode(state)}"}
                figure.draw_without_rendering()
                figure.set_layout_engine("none")  # laid out once, not for each file
                add(f"{name}.svg", _written(figure, "svg", {**about, "Creator": "IDO Explorer", "Date": None}))
                add(f"{name}.png", _written(figure, "png", {**about, "Software": "IDO Explorer"}))
        add("README.txt", readme(run, state).encode())
    return archive.getvalue()


def _figures(run: Run, state: State) -> dict[str, Figure]:
    """By the names of their files."""
    figures = {"histograms": histograms_figure(run, state), "curves": curves_figure(run, state)}
    if any(side.maps for side in run.sides):
        figures["maps"] = maps_figure(run, state)
    return figures


def _written(figure: Figure, kind: str, metadata: dict[str, str | None]) -> bytes:
    content = io.BytesIO()
    figure.savefig(content, format=kind, dpi=DOTS_PER_INCH, metadata=metadata)
    return content.getvalue()


def readme(run: Run, state: State) -> str:
    """What the figures show, of which scene and by which methods; plain text."""
    k = shown_iteration(run, state)
    values = "histogram minus reference line" if state.difference else "histogram (dots) and reference line"
    lines = [
        f"Charts of IDO Explorer: {_names(run)}",
        "",
        f"Scene       {scene_line(state)}",
        f"Outliers    {state.perturbation.outlier_kind}; lengths are in model units",
        f"State       {encode(state)}",
        "            (paste it into Share, or start with ido-viz --state CODE)",
        "",
        *(_of_side(side, where, k) for side, where in zip(run.sides, ("Left ", "Right"), strict=True)),
        "",
        f"histograms  {values} after iteration {k}; bins of each side of a block by {state.order};",
        "            each block is relative to its largest reference bin",
    ]
    if any(side.maps for side in run.sides):
        which = "the pinned map" if state.pinned_map else f"the map that makes the update after iteration {k}"
        lines += [f"maps        {which}: what each bin adds to the translation (ρ) and rotation (φ)"]
    lines += [f"maps        none of {one_line(side.method)}: it learns none" for side in run.sides if not side.maps]
    lines += [
        "curves      over the iterations; dots where the histograms are taken, dotted: ε of learned methods",
        "",
        f"Every figure is {WIDTH} inches wide (two columns), the PNG with {DOTS_PER_INCH} dots per inch. Text in the",
        "SVG is text, set in DejaVu Sans, or in Arial or Helvetica where that is not installed.",
    ]
    return "\n".join(lines) + "\n"


def _of_side(side: MethodRun, where: str, iteration: int) -> str:
    k = side.clipped(iteration)
    scores = f"PointRMSE {side.scores.rmse[k]:.4f}, PointAcc {side.scores.accuracy[k]:.4f}"
    track = side.trajectory
    return (
        f"{where}       {one_line(side.method)}: {track.iterations} iterations, then {track.stop}; after {k}: {scores}"
    )


def _names(run: Run) -> str:
    return " and ".join(one_line(side.method) for side in run.sides)
