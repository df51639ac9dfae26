"""The docked panels: controls on the left, charts and heatmaps on the right."""

from __future__ import annotations

from typing import Any

import viser

from ido_viz.actions import Actions
from ido_viz.charts import ErrorCharts, HistogramChart, caption
from ido_viz.compare import ComparePanel, Comparison
from ido_viz.derivations import Derivations
from ido_viz.heatmaps import ComparedMaps, Heatmap
from ido_viz.inspect_panel import InspectPanel
from ido_viz.lesson_panel import LessonPanel
from ido_viz.microscope import Inspections, inspected_number
from ido_viz.run import Run
from ido_viz.state import Part, State
from ido_viz.sweeps import SweepPanel
from ido_viz.training import TrainingCharts

CONTROLS_WIDTH = 300
CHARTS_WIDTH = 400
LARGE_TEXT = 1.25
"""How much larger text is for a projector."""

_WIDER = 1.14  # panels are then, less than the text, for the canvas needs its room

_HELP = """
**Two methods register the same scene**, side by side. The scene is a copy of the grey *model* that was turned, moved,
made noisy, cut off and mixed with outliers. Each method has to find the way back, step by step, to where the green
points are. Press **Play**, then drag a slider on the left.

**How they move.** At every iteration a method looks at the scene through a *histogram*, and a learned *map* turns what
it sees into the next update of the pose: `x ← x - D · h(x)`. There are 30 maps; the last one is repeated until the
updates are smaller than ε.

**What they see.** Each model point asks of the scene points near it: in front of me, or behind me? That is DO, and
gives two bins for each model point. Improved DO also asks of all scene points: above me or below me, clockwise or
anticlockwise of me?

**The histograms** show every bin as a dot. The line is the *reference*: what the model sees of itself. When the scene
is in its place, the dots gather along it.

**The maps** show, for each bin, how it pushes the six numbers of the pose: translation ρ and rotation φ, one way in
blue and the other in red.
"""


def _chart_height(window: int) -> int:
    """Height at which two histograms fill the upper half of a window."""
    return min(max(round(0.29 * window) - 112, 104), 200)


class Panels:
    """Places the panels of one page and draws what they hold."""

    def __init__(self, client: viser.ClientHandle, state: State, actions: Actions) -> None:
        gui = client.gui
        gui.set_panel_label("IDO Explorer")
        gui.main_panel.dock_left()
        self._tell_scores: list[viser.GuiFolderHandle] = []
        lessons = gui.add_folder("Lessons", order=-1)  # above the controls, so that the charts stay in sight
        with lessons:
            LessonPanel(gui, actions.open_page, state)
        top = gui.add_panel(order=0)
        with top.add_tab("Histograms"):
            height = _chart_height(client.camera.image_height)
            self._histograms = [HistogramChart(gui, side, height) for side in range(2)]
        with top.add_tab("Training"):
            self._training = TrainingCharts(gui)
        with top.add_tab("Derivations"):
            self._derivations = Derivations(gui)
        with top.add_tab("Help"):
            gui.add_markdown(_HELP)
        bottom = gui.add_panel(order=1)
        with bottom.add_tab("Maps"):
            self._heatmaps = [Heatmap(gui, side) for side in range(2)]
            gui.add_html(caption("<b>Maps 1, 15 and 30</b>, as in the paper's figure"))
            self._compared = ComparedMaps(gui)
        with bottom.add_tab("Errors"), self._telling(gui):
            self._errors = ErrorCharts(gui)
        with bottom.add_tab("Compare"), self._telling(gui):
            self._compare = ComparePanel(
                gui, actions.compare, actions.cancel_comparison, actions.show_method, actions.redraw
            )
        with bottom.add_tab("Sweeps"), self._telling(gui):
            self._sweeps = SweepPanel(gui, actions.open_scene, actions.redraw)
        with bottom.add_tab("Inspect"):
            self._inspect = InspectPanel(gui, state, actions.inspect)
        self._gui, self._top, self._bottom = gui, top, bottom
        self._style = gui.add_html("")
        self._parts: dict[Part, list[Any]] = {"lessons": [lessons], "scores": self._tell_scores}
        self._placed: tuple[bool, ...] | None = None

    def _telling(self, gui: viser.GuiApi) -> viser.GuiFolderHandle:
        """A container for what tells the scores."""
        self._tell_scores.append(gui.add_folder(None))
        return self._tell_scores[-1]

    def _place(self, state: State) -> None:
        """Set the size that all text is relative to, and show the panels that are not hidden, as wide as it needs."""
        shown = ("upper charts" not in state.hidden, "lower charts" not in state.hidden)
        if (*shown, state.large_text) == self._placed:
            return
        self._placed = (*shown, state.large_text)
        scale = LARGE_TEXT if state.large_text else 1.0
        self._style.content = f"<style>html{{font-size:{100 * scale:g}%}}</style>"
        wider = _WIDER if state.large_text else 1.0
        self._gui.main_panel.set_width(round(CONTROLS_WIDTH * wider))
        above = None
        for panel, visible in zip((self._top, self._bottom), shown, strict=True):
            panel.visible = visible
            if not visible:
                continue
            if above is None:  # a panel that was hidden has lost its place
                panel.dock_right()
                panel.set_width(round(CHARTS_WIDTH * wider))
            else:
                panel.dock_below(above)
            above = panel

    def _hide_parts(self, state: State) -> None:
        for part, handles in self._parts.items():
            for handle in handles:
                if handle.visible != (part not in state.hidden):
                    handle.visible = part not in state.hidden

    def draw(self, run: Run, comparison: Comparison, state: State, iteration: int, inspections: Inspections) -> None:
        """Draw everything after so many iterations."""
        self._place(state)
        self._hide_parts(state)
        self._inspect.draw(inspections[inspected_number(state)], state)
        self._compare.draw(comparison, state)
        self._sweeps.draw(state)
        for chart, heatmap, inspection in zip(self._histograms, self._heatmaps, inspections, strict=True):
            chart.draw(run, state, iteration, inspection)
            heatmap.draw(run, state, iteration, inspection)
        self._errors.draw(run, state, iteration)
        self._compared.draw(run, state)
        self._training.draw(run, state)
        self._derivations.draw(state.dark)
