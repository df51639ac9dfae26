"""The tab Compare: a table of all methods that fills as they finish, its rows buttons that show the method."""

from __future__ import annotations

import html
from collections.abc import Sequence

import viser

from ido_viz.core.actions import Actions, plain
from ido_viz.core.comparison import SORTS, Comparison, Row
from ido_viz.core.state import State


class CompareTab:
    """The table and its controls."""

    def __init__(self, gui: viser.GuiApi, actions: Actions) -> None:
        self._gui = gui
        self._show = actions.show_method
        self._start = gui.add_button(
            "Compare all methods", hint="Register the scene that is shown with every method and setting."
        )
        self._start.on_click(plain(actions.compare))
        self._cancel = gui.add_button(
            "Cancel", color="gray", disabled=True, hint="Keep the rows that are there and stop."
        )
        self._cancel.on_click(plain(actions.cancel_comparison))
        self._sort = gui.add_dropdown("Sort by", tuple(SORTS), initial_value="PointAcc", hint="Best first.")
        self._sort.on_update(plain(actions.redraw))
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
        if self._cancel.disabled == comparison.running:
            self._cancel.disabled = not comparison.running
        rows = sorted(comparison.rows, key=SORTS[self._sort.value])
        head = head_html(
            len(rows), len(comparison.methods), comparison.running, comparison.fits(state), comparison.waiting
        )
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


def label(row: Row) -> str:
    """A row in columns of fixed width."""
    name = row.method.replace("reconstruction", "reconstr.")
    name = name if len(name) <= 25 else f"{name[:24]}…"
    if row.failure:
        return f"{name:<26}{('✗ ' + row.failure)[:24]:>24}"
    return f"{name:<26}{row.accuracy:6.3f}{row.rmse:7.3f}{1e3 * row.seconds:6.0f}{row.iterations:5d}"


COLUMNS = f"{'':<26}{'Acc':>6}{'RMSE':>7}{'ms':>6}{'its':>5}"
"""Heads of the columns; its stands for iterations."""

_ROWS = ":is(div:has(> .ido-rows), div:has(> div > .ido-rows)) ~ div"  # what follows it, and not what follows the tab
_STYLE = f"""<style>
{_ROWS} .mantine-Button-label {{ font: 0.66rem monospace; white-space: pre; }}
{_ROWS} div:has(> .mantine-Button-root) {{ padding-bottom: 0 !important; }}
{_ROWS} .mantine-Button-root {{ height: 1.25rem !important; padding: 0; background: transparent;
  color: var(--mantine-color-text); border-bottom: 1px solid rgba(128,128,128,.25); }}
{_ROWS} .mantine-Button-root:hover {{ background: rgba(0,114,178,.15); }}
</style>"""  # the rows of a table, out of buttons


def head_html(done: int, total: int, running: bool, fits: bool, waiting: str = "") -> str:
    """What the table is of, whether it waits for others' work, and the heads of its columns."""
    if total == 0:
        return '<div style="margin:0 8px;font-size:0.75rem">Every method and setting on the scene that is shown.</div>'
    text = f"{done} of {total} methods" + ("…" if running else ", then cancelled" if done < total else "")
    if waiting:
        text += f" {waiting}"
    if not fits:
        text += ". The scene has changed since: compare again."
    return (
        f'{_STYLE}<div class="ido-rows" style="margin:0 8px;font-size:0.75rem"><div>{html.escape(text)}</div>'
        f'<div style="font:0.66rem monospace;white-space:pre;text-align:center;margin-top:4px">{COLUMNS}</div></div>'
    )
