"""The docked panels: controls on the left, charts and heatmaps on the right."""

from __future__ import annotations

import viser

from ido_viz.charts import ErrorCharts, HistogramChart
from ido_viz.heatmaps import ComparedMaps, Heatmap
from ido_viz.run import Run
from ido_viz.state import State
from ido_viz.training import TrainingCharts

CONTROLS_WIDTH = 300
CHARTS_WIDTH = 400


def _chart_height(window: int) -> int:
    """Height at which two histograms fill the upper half of a window."""
    return min(max(round(0.29 * window) - 105, 104), 200)


class Panels:
    """Places the panels of one page and draws what they hold."""

    def __init__(self, client: viser.ClientHandle) -> None:
        gui = client.gui
        gui.set_panel_label("IDO Explorer")
        gui.main_panel.dock_left()
        gui.main_panel.set_width(CONTROLS_WIDTH)
        top = gui.add_panel(order=0)
        with top.add_tab("Histograms", viser.Icon.CHART_HISTOGRAM):
            height = _chart_height(client.camera.image_height)
            self._histograms = [HistogramChart(gui, side, height) for side in range(2)]
        bottom = gui.add_panel(order=1)
        with bottom.add_tab("Maps"):
            self._heatmaps = [Heatmap(gui, side) for side in range(2)]
        with bottom.add_tab("Errors"):
            self._errors = ErrorCharts(gui)
        with bottom.add_tab("Maps 1, 15, 30"):
            self._compared = ComparedMaps(gui)
        with bottom.add_tab("Training"):
            self._training = TrainingCharts(gui)
        top.dock_right()
        top.set_width(CHARTS_WIDTH)
        bottom.dock_below(top)

    def draw(self, run: Run, state: State, iteration: int) -> None:
        """Draw everything after so many iterations."""
        for chart in self._histograms:
            chart.draw(run, state, iteration)
        for heatmap in self._heatmaps:
            heatmap.draw(run, state, iteration)
        self._errors.draw(run, state, iteration)
        self._compared.draw(run, state)
        self._training.draw(run, state)
