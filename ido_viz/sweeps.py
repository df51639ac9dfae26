"""The shipped results of the paper's experiments: sweep curves of every method, and the scenes behind them."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser

from ido import Perturbation
from ido.baselines import Nothing
from ido.experiments import LEVELS, Results, level_scene
from ido.experiments.results import ResultsError
from ido.experiments.run import MOST_SCENES, SEED
from ido.methods import method_names
from ido.shipped import SHAPES, shipped_results
from ido_viz import palette
from ido_viz.charts import Plot, caption, plain_axes
from ido_viz.state import LAST, State

SCORES = {"PointAcc": "accuracy", "PointRMSE": "rmse"}
GROUPS: dict[str, Callable[[str], bool]] = {
    "learned and tuned": lambda method: not method.endswith("default"),
    "learned and default": lambda method: not method.endswith("tuned"),
    "all": lambda method: True,
}
_FAMILIES = ("DO", "Improved DO", Nothing.title, "ICP", "CPD", "BCPD", "GMMReg", "KCCE")  # in the palette's order


@dataclass(frozen=True, slots=True)
class Choice:
    """A registration of the shipped results."""

    shape: str
    sweep: str
    level: float
    trial: int
    method: str

    def at(self, state: State) -> State:
        """The state that shows it, at its end, in the right pane."""
        base = Perturbation(outlier_kind=SHAPES[self.shape].outlier_kind)
        others = (state.left, State().left, State().right)
        return State(
            shape=self.shape,
            perturbation=level_scene(base, self.sweep, self.level, self.trial, MOST_SCENES, SEED),
            left=next(method for method in others if method != self.method and method in method_names(self.shape)),
            right=self.method,
            iteration=LAST,
            playing=False,
            dark=state.dark,
        )


class SweepPanel:
    """Curves over a sweep, and the way to the scene of one of its registrations."""

    def __init__(self, gui: viser.GuiApi, open_scene: Callable[[Choice], None], changed: Callable[[], None]) -> None:
        self._open = open_scene
        self._changed = changed
        self._shape = ""
        self._rows: Results | None = None
        self._sweep = gui.add_dropdown("Sweep", tuple(LEVELS), initial_value="noise")
        self._score = gui.add_dropdown("Score", tuple(SCORES), initial_value="PointAcc")
        self._group = gui.add_dropdown("Methods", tuple(GROUPS), initial_value="learned and tuned")
        self._legend = gui.add_html("")
        self._plot = Plot(gui, height=150)
        self._method = gui.add_dropdown("Method", ("DO",), initial_value="DO")
        self._level = gui.add_dropdown("Level", ("0",), initial_value="0")
        self._trial = gui.add_dropdown("Scene", ("–",), initial_value="–", hint="Scenes of this level, worst first.")
        self._button = gui.add_button("Open this scene", hint="Shows it in the panes, the method on the right.")
        for handle in (self._sweep, self._score, self._group, self._method, self._level):
            handle.on_update(lambda event: changed() if event.client else None)
        self._button.on_click(lambda _: self._choose())
        self._look: tuple[object, ...] | None = None

    def draw(self, state: State) -> None:
        """Draw what is chosen, of the state's shape."""
        look = self._looks(state)
        if look == self._look:
            return
        self._look = look
        try:
            results = shipped_results()
        except ResultsError as error:  # the rest of the page does without them
            self._legend.content = caption(html.escape(f"The results cannot be read: {error}"))
            return
        rows = results.where(dataset=state.shape, sweep=self._sweep.value)
        self._shape, self._rows = state.shape, rows
        found = set(rows.method.tolist())
        methods = tuple(method for method in method_names(state.shape) if method in found) if found else ()
        if not methods:
            self._legend.content = caption("There are no shipped results for this shape.")
            return
        _offer(self._method, methods)
        _offer(self._level, tuple(f"{level:g}" for level in LEVELS[self._sweep.value]))
        scenes = scene_labels(rows, self._method.value, float(self._level.value))
        _offer(self._trial, tuple(scenes))
        shown = [method for method in methods if GROUPS[self._group.value](method)]
        self._legend.content = legend_html(shown, len(np.unique(rows.trial)))
        levels = np.array(LEVELS[self._sweep.value], dtype=np.float64)
        curves = [curve(rows, method, SCORES[self._score.value], levels) for method in shown]
        series: list[Any] = [{"label": self._sweep.value}, *(series_of(method) for method in shown)]
        high = 1.05 if self._score.value == "PointAcc" else 1.1 * float(np.nanmax(curves))
        scales = {
            "x": {"time": False, "auto": False, "range": (float(levels[0]), float(levels[-1]))},
            "y": {"auto": False, "range": (0.0, high)},
        }
        self._plot.restyle((levels, *curves), series, scales, plain_axes(state.dark))
        self._look = self._looks(state)  # the choices on offer may have changed with the sweep

    def _looks(self, state: State) -> tuple[object, ...]:
        chosen = (self._sweep, self._score, self._group, self._method, self._level)
        return (state.shape, state.dark, *(handle.value for handle in chosen))

    def _choose(self) -> None:
        if self._rows is None or self._trial.value == "–":
            return
        trial = int(self._trial.value.split()[0])
        level = LEVELS[self._sweep.value][[f"{v:g}" for v in LEVELS[self._sweep.value]].index(self._level.value)]
        self._open(Choice(self._shape, self._sweep.value, level, trial, self._method.value))


def _offer(dropdown: Any, options: tuple[str, ...]) -> None:
    if dropdown.options != options:
        dropdown.options = options


def curve(rows: Results, method: str, score: str, levels: np.ndarray) -> np.ndarray:
    """Mean score of a method at each level, shape (levels,); NaN where it was not run."""
    own = rows.where(method=method)
    values = [getattr(own, score)[np.isclose(own.level, level)] for level in levels]
    return np.array([found.mean() if len(found) else np.nan for found in values])


def scene_labels(rows: Results, method: str, level: float) -> list[str]:
    """The scenes of a method at a level, worst first: number and PointAcc."""
    own = rows.where(method=method)
    at_level = np.flatnonzero(np.isclose(own.level, level))
    order = at_level[np.lexsort((own.trial[at_level], own.accuracy[at_level]))]
    return [f"{own.trial[i]} (PointAcc {own.accuracy[i]:.2f})" for i in order] or ["–"]


def family(method: str) -> str:
    """The method without its setting."""
    return next(name for name in reversed(_FAMILIES) if method.startswith(name))


def series_of(method: str) -> dict[str, Any]:
    """How a method is drawn: its family's colour, dashed where it is not at its best."""
    color = palette.css(palette.FAMILIES[_FAMILIES.index(family(method))])
    dashes = {"dash": [5, 4]} if method.endswith(("default", "as printed)")) else {}
    return {"label": method, "stroke": color, "width": 2, "points": {"show": True, "size": 4, "fill": color}, **dashes}


def legend_html(methods: list[str], scenes: int) -> str:
    """The methods in their colours."""
    names = " &nbsp;".join(
        f'<span style="white-space:nowrap"><span style="color:{series_of(method)["stroke"]}">'
        f"{'┅' if 'dash' in series_of(method) else '━'}</span> {html.escape(method)}</span>"
        for method in methods
    )
    return caption(f"Mean over {scenes} scenes a level. {names}")
