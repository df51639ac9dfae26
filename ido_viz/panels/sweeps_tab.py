"""The tab Sweeps: curves of the shipped results, and the way to the scene of any of their registrations."""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser

from ido.experiments import LEVELS, Results
from ido.experiments.families import COMPARED_METHODS, FAMILIES
from ido_viz.core import palette
from ido_viz.core.state import State
from ido_viz.core.sweep_results import GROUPS, SCORES, Choice, mean_scores, rows_of, scene_labels
from ido_viz.panels.markup import caption
from ido_viz.panels.plot import Plot, plain_axes


class SweepsTab:
    """Curves over a sweep, and the way to the scene of one of its registrations."""

    def __init__(self, gui: viser.GuiApi, open_scene: Callable[[Choice], None], changed: Callable[[], None]) -> None:
        self._open = open_scene
        self._changed = changed
        self._shape = ""
        self._sweep = gui.add_dropdown(
            "Sweep", tuple(LEVELS), initial_value="noise", hint="What is varied; all else is at the paper's default."
        )
        self._score = gui.add_dropdown(
            "Score", tuple(SCORES), initial_value="PointAcc", hint="Share of points in place, or their mean error."
        )
        self._group = gui.add_dropdown(
            "Methods", tuple(GROUPS), initial_value=next(iter(GROUPS)), hint="Whose curves are drawn."
        )
        self._legend = gui.add_html("")
        self._plot = Plot(gui, height=150)
        self._method = gui.add_dropdown("Method", ("DO",), initial_value="DO", hint="Whose scenes are listed below.")
        self._level = gui.add_dropdown("Level", ("0",), initial_value="0", hint="Of the sweep.")
        self._trial = gui.add_dropdown("Scene", ("–",), initial_value="–", hint="Scenes of this level, worst first.")
        self._button = gui.add_button(
            "Open this scene", hint="Shows it in the panes: the method where it is already, or on the right."
        )
        for handle in (self._sweep, self._score, self._group, self._method, self._level):
            handle.on_update(lambda event: changed() if event.client else None)
        self._button.on_click(lambda _: self._choose())
        self._look: tuple[object, ...] | None = None

    def draw(self, state: State) -> None:
        """Draw what is chosen, of the state's shape."""
        sweep, score, group, *_ = chosen = self._chosen()  # once: a person may choose others meanwhile
        look = (state.shape, state.dark, state.large_text)
        if (*look, *chosen) == self._look:
            return
        self._shape = state.shape
        levels = LEVELS[sweep]
        rows, missing = rows_of(state.shape, sweep)
        methods = tuple(dict.fromkeys(name for name in COMPARED_METHODS if (rows.method == name).any()))
        _offer(self._method, methods or ("–",))
        _offer(self._level, tuple(f"{level:g}" for level in levels))
        *_, method, level = self._chosen()  # what is on offer may have changed with the sweep
        _offer(self._trial, tuple(scene_labels(rows, method, levels[self._level.options.index(level)])))
        self._button.disabled = not methods
        shown = [name for name in methods if GROUPS[group](name)]
        self._legend.content = caption(html.escape(missing)) if missing else legend_html(shown, rows, state.dark)
        curves = [mean_scores(rows, name, SCORES[score], levels) for name in shown]
        highest = max((float(np.nanmax(values)) for values in curves), default=1.0)
        scales = {
            "x": {"time": False, "auto": False, "range": (float(levels[0]), float(levels[-1]))},
            "y": {"auto": False, "range": (0.0, 1.05 if score == "PointAcc" else 1.1 * highest)},
        }
        series: list[Any] = [{"label": sweep}, *(series_of(name, state.dark) for name in shown)]
        if not curves:  # a chart must have one
            curves, series = [np.full(len(levels), np.nan)], [*series, {"points": {"show": False}}]
        self._plot.restyle((np.array(levels, dtype=np.float64), *curves), series, scales, plain_axes(state))
        self._look = (*look, sweep, score, group, method, level)

    def show_sweep(self, sweep: str) -> None:
        """Choose a sweep, as its menu does."""
        self._sweep.value = sweep
        self._changed()

    def _chosen(self) -> tuple[str, str, str, str, str]:
        """Sweep, score, group, method and level."""
        return self._sweep.value, self._score.value, self._group.value, self._method.value, self._level.value

    def _choose(self) -> None:
        if self._trial.value != "–":
            level = LEVELS[self._sweep.value][self._level.options.index(self._level.value)]
            trial = int(self._trial.value.split()[0])
            self._open(Choice(self._shape, self._sweep.value, level, trial, self._method.value))


def _offer(dropdown: Any, options: tuple[str, ...]) -> None:
    if dropdown.options != options:
        dropdown.options = options


def series_of(method: str, dark: bool) -> dict[str, Any]:
    """How a method is drawn: in its colour, and dashed for each variant of a family but the first."""
    its = next(family for family in FAMILIES if method in (name for _, name in family.variants))
    color = palette.css(palette.method_color(method, dark))
    number = [name for _, name in its.variants].index(method)
    dashes = {"dash": [5 // number, 4]} if number else {}
    return {"label": method, "stroke": color, "width": 2, "points": {"show": True, "size": 4, "fill": color}, **dashes}


def legend_html(methods: Sequence[str], rows: Results, dark: bool) -> str:
    """The methods in their colours."""
    names = " &nbsp;".join(
        f'<span style="white-space:nowrap">{_key(method, dark)} {html.escape(method)}</span>' for method in methods
    )
    return caption(f"Mean over {len(np.unique(rows.trial))} scenes a level. {names}")


def _key(method: str, dark: bool) -> str:
    """A piece of a method's line."""
    its = series_of(method, dark)
    line = f"border-top:3px {'dashed' if 'dash' in its else 'solid'} {its['stroke']}"
    return f'<span style="display:inline-block;width:1.3em;vertical-align:middle;{line}"></span>'
