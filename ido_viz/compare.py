"""All methods on the scene that is shown: a table that fills as they finish, its rows buttons that show the method."""

from __future__ import annotations

import html
import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import viser

from ido import Method, Scene, score
from ido.registration import Watch
from ido_viz.background import CancelledError, Job, Report
from ido_viz.library import Library
from ido_viz.run import make_scene
from ido_viz.state import State

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Row:
    """What one method made of the scene."""

    method: str
    accuracy: float
    rmse: float
    seconds: float
    iterations: int
    failure: str = ""


SORTS: dict[str, Callable[[Row], tuple[float, ...]]] = {
    "PointAcc": lambda row: (-round(row.accuracy, 3), row.rmse),  # of equal ones the nearer first
    "PointRMSE": lambda row: (row.rmse,),
    "time": lambda row: (row.seconds,),
    "iterations": lambda row: (row.iterations,),
}
"""What the table can be sorted by, best first."""


class Comparison:
    """The rows that are there so far, of the scene that a comparison was last begun for.

    Args:
        library: the methods.
        changed: called on another thread when a look is worth while.
    """

    def __init__(self, library: Library, changed: Callable[[], None]) -> None:
        self._library = library
        self._changed = changed
        self._job: Job[None] | None = None
        self._of: tuple[object, ...] | None = None
        self._rows: list[Row] = []
        self.methods: tuple[str, ...] = ()

    @property
    def rows(self) -> tuple[Row, ...]:
        """Those that are there, in the order of the methods."""
        return tuple(self._rows)

    @property
    def running(self) -> bool:
        """Whether rows are still to come."""
        return self._job is not None and not self._job.ended

    def fits(self, state: State) -> bool:
        """Whether the rows are of the state's scene."""
        return self._of == _inputs(state)

    def begin(self, state: State) -> None:
        """Register the state's scene with every method, the one after the other."""
        self.cancel()
        self._of, self.methods = _inputs(state), self._library.methods(state.shape)
        self._rows = rows = []  # of this comparison alone; one that is still ending has its own
        self._job = Job(lambda report: self._fill(state, rows, report), self._changed)

    def cancel(self) -> None:
        """Leave it at the rows that are there."""
        if self._job is not None:
            self._job.cancel()

    def _fill(self, state: State, rows: list[Row], report: Report) -> None:
        scene = make_scene(state, self._library)
        for name in self._library.methods(state.shape):
            try:
                rows.append(measured(self._library.method(state, name, report), scene, report))
            except CancelledError:
                raise
            except BaseException as error:  # the others are still of interest; one of one's own may call sys.exit
                _log.exception("%s failed", name)
                rows.append(Row(name, 0.0, np.inf, np.inf, 0, failure=type(error).__name__))
            self._changed()


def measured(method: Method, scene: Scene, watch: Watch) -> Row:
    """One method's row; its time is without what only the first registration takes."""
    method.register(scene.points[:10], watch=watch)  # loads and compiles
    began = time.perf_counter()
    track = method.register(scene.points, watch=watch)
    seconds = time.perf_counter() - began
    scores = score(scene, track.T_model_scene[-1])
    return Row(method.name, float(scores.accuracy), float(scores.rmse), seconds, track.iterations)


def _inputs(state: State) -> tuple[object, ...]:
    return (state.shape, state.perturbation, state.epsilon, state.max_iterations)


class ComparePanel:
    """The table and its controls."""

    def __init__(
        self,
        gui: viser.GuiApi,
        begin: Callable[[], None],
        cancel: Callable[[], None],
        show: Callable[[str, str], None],
        changed: Callable[[], None],
    ) -> None:
        self._gui = gui
        self._show = show
        self._start = gui.add_button(
            "Compare all methods", hint="Register the scene that is shown with every method and setting."
        )
        self._start.on_click(lambda _: begin())
        self._cancel = gui.add_button(
            "Cancel", color="gray", visible=False, hint="Keep the rows that are there and stop."
        )
        self._cancel.on_click(lambda _: cancel())
        self._sort = gui.add_dropdown("Sort by", tuple(SORTS), initial_value="PointAcc", hint="Best first.")
        self._sort.on_update(lambda _: changed())
        self._pane = gui.add_dropdown(
            "Show in the",
            ("left pane", "right pane"),
            initial_value="right pane",
            hint="Where the method of a row is shown when you press it.",
        )
        self._head = gui.add_html("")
        self._folder = gui.add_folder(None)
        self._buttons: list[viser.GuiButtonHandle] = []
        self._shown: tuple[str, ...] = ()
        self._rows: Sequence[Row] = ()

    def draw(self, comparison: Comparison, state: State) -> None:
        """Draw the rows that are there."""
        self._set_visible(comparison.running)
        rows = sorted(comparison.rows, key=SORTS[self._sort.value])
        head = head_html(len(rows), len(comparison.methods), comparison.running, comparison.fits(state))
        if self._head.content != head:
            self._head.content = head
        labels = tuple(map(label, rows))
        if labels == self._shown:
            return
        self._shown = labels
        self._rows = rows  # before there are buttons that look there
        while len(self._buttons) < len(labels):
            self._add_button()
        for button, text in zip(self._buttons, labels, strict=False):
            button.label = text
        for i, button in enumerate(self._buttons):
            button.visible = i < len(labels)

    def _add_button(self) -> None:
        number = len(self._buttons)
        with self._folder:
            button = self._gui.add_button("", color="gray", hint="Show this method in a pane.")
        button.on_click(lambda _: self._show(self._rows[number].method, self._pane.value.split()[0]))
        self._buttons.append(button)

    def _set_visible(self, running: bool) -> None:
        if self._cancel.visible != running:
            self._cancel.visible = running


def label(row: Row) -> str:
    """A row in columns of fixed width."""
    name = row.method.replace("reconstruction", "reconstr.")[:26]
    if row.failure:
        return f"{name:<26}{('✗ ' + row.failure)[:24]:>24}"
    return f"{name:<26}{row.accuracy:6.3f}{row.rmse:7.3f}{1e3 * row.seconds:6.0f}{row.iterations:5d}"


COLUMNS = f"{'':<26}{'Acc':>6}{'RMSE':>7}{'ms':>6}{'its':>5}"
"""Heads of the columns; its stands for iterations."""

_STYLE = (  # the rows of a table, out of buttons
    "<style>div:has(.ido-rows) ~ div .mantine-Button-label{font:0.66rem monospace;white-space:pre}"
    "div:has(.ido-rows) ~ div div:has(> .mantine-Button-root){padding-bottom:0!important}"
    "div:has(.ido-rows) ~ div .mantine-Button-root{height:1.25rem!important;padding:0;background:transparent;"
    "color:var(--mantine-color-text);border-bottom:1px solid rgba(128,128,128,.25)}"
    "div:has(.ido-rows) ~ div .mantine-Button-root:hover{background:rgba(0,114,178,.15)}</style>"
)


def head_html(done: int, total: int, running: bool, fits: bool) -> str:
    """What the table is of, and the heads of its columns."""
    if total == 0:
        return '<div style="margin:0 8px;font-size:0.75rem">Every method and setting on the scene that is shown.</div>'
    text = f"{done} of {total} methods" + ("…" if running else ", then cancelled" if done < total else "")
    if not fits:
        text += ". The scene has changed since: compare again."
    return (
        f'{_STYLE}<div class="ido-rows" style="margin:0 8px;font-size:0.75rem"><div>{html.escape(text)}</div>'
        f'<div style="font:0.66rem monospace;white-space:pre;text-align:center;margin-top:4px">{COLUMNS}</div></div>'
    )
