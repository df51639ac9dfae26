"""Pieces of HTML that panels share. What comes from a user is escaped here."""

from __future__ import annotations

import html

from ido_viz.core import palette
from ido_viz.core.run import MethodRun, Run


def caption(content: str) -> str:
    """A small line of text above a chart; `content` is HTML."""
    return f'<div style="font-size:0.75rem;line-height:1.3;margin:2px 8px 0 8px">{content}</div>'


def signed(value: float, digits: int) -> str:
    """A number with its sign and so many decimals; what is rounded to nothing has none."""
    text = f"{value:+.{digits}f}"
    return text if float(text) else text[1:]


def method_span(method: str, dark: bool) -> str:
    """A method's name in its colour."""
    color = palette.text(palette.method_color(method, dark), dark)
    return f'<span style="color:{palette.css(color)}">● {html.escape(method)}</span>'


def both_methods(run: Run, dark: bool) -> str:
    """Both methods' names in their colours."""
    return " &nbsp; ".join(method_span(side.method, dark) for side in run.sides)


def no_maps(side: MethodRun, dark: bool) -> str:
    """What stands in the place of the maps of a baseline, or of a method that is not there yet."""
    why = "has no maps yet" if side.waiting else "learns no maps"
    return caption(f"<b>{method_span(side.method, dark)}</b> {why}")


def table_html(head: tuple[str, ...], rows: list[tuple[str, ...]], marked: str = "") -> str:
    """A table with its first column to the left and numbers to the right, the column of a name marked."""
    marks = [bool(marked) and name == marked for name in head]
    cells = "".join(_cell("th", i, c, marks[i]) for i, c in enumerate(head))
    body = "".join("<tr>" + "".join(_cell("td", i, c, marks[i]) for i, c in enumerate(row)) + "</tr>" for row in rows)
    return (
        '<table style="width:calc(100% - 16px);margin:2px 8px 6px 8px;font-size:0.64rem;line-height:1.4;'
        f'font-variant-numeric:tabular-nums;border-collapse:collapse"><tr>{cells}</tr>{body}</table>'
    )


def _cell(kind: str, column: int, content: str, marked: bool) -> str:
    look = "text-align:" + ("right;padding-left:0.4em" if column else "left")
    look += f";background:{palette.css(palette.MARK, 0.35)}" if marked else ""
    return f'<{kind} style="{look}">{html.escape(content)}</{kind}>'
