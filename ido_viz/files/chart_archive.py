"""The charts of a page as an archive for a paper: each as SVG and PNG, and a text that says what they show."""

from __future__ import annotations

import io
import threading
import zipfile

import matplotlib
from matplotlib.figure import Figure

from ido.experiments.figures import as_svg_and_png
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.run import Run
from ido_viz.core.state import encode
from ido_viz.core.wording import one_line, scene_line
from ido_viz.files.chart_figures import DOTS_PER_INCH, STYLE, WIDTH, curves_figure, histograms_figure, maps_figure

_drawing = threading.Lock()  # Matplotlib's settings are everybody's


def charts_zip(frame: Frame) -> bytes:
    """The charts of a page as an archive: each as .svg and .png, and a README.txt that says what they show.

    Figures are `WIDTH` inches wide, on white whether the page is dark or not; text in the SVGs is text. Where neither
    method has maps there is no figure of them. The same state gives the same bytes.
    """
    run, state = frame.run, frame.state
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as members:

        def add(name: str, content: bytes) -> None:
            members.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)

        with _drawing, matplotlib.rc_context(STYLE):
            for name, figure in _figures(frame).items():
                about = {"Title": f"{name}: {_names(run)}", "Description": f"{scene_line(state)}; {encode(state)}"}
                of_svg = {**about, "Creator": "IDO Explorer", "Date": None}
                svg, png = as_svg_and_png(figure, DOTS_PER_INCH, of_svg, {**about, "Software": "IDO Explorer"})
                add(f"{name}.svg", svg)
                add(f"{name}.png", png)
        add("README.txt", readme(frame).encode())
    return archive.getvalue()


def _figures(frame: Frame) -> dict[str, Figure]:
    """By the names of their files."""
    figures = {"histograms": histograms_figure(frame), "curves": curves_figure(frame)}
    if any(side.run.maps for side in frame.sides):
        figures["maps"] = maps_figure(frame)
    return figures


def readme(frame: Frame) -> str:
    """What the figures show, of which scene and by which methods; plain text."""
    run, state, k = frame.run, frame.state, frame.k
    values = "histogram minus reference line" if state.difference else "histogram (dots) and reference line"
    lines = [
        f"Charts of IDO Explorer: {_names(run)}",
        "",
        f"Scene       {scene_line(state)}",
        f"Outliers    {state.perturbation.outlier_kind}; lengths are in model units",
        f"State       {encode(state)}",
        "            (paste it into Share, or start with ido-viz --state CODE)",
        "",
        *map(_of_side, frame.sides, ("Left ", "Right")),
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


def _of_side(side: SideFrame, where: str) -> str:
    scores, track = f"PointRMSE {side.rmse:.4f}, PointAcc {side.accuracy:.4f}", side.run.trajectory
    name = one_line(side.run.method)
    return f"{where}       {name}: {track.iterations} iterations, then {track.stop}; after {side.k}: {scores}"


def _names(run: Run) -> str:
    return " and ".join(one_line(side.method) for side in run.sides)
