"""The report's page around its tables and figures: one HTML file that needs nothing else."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape

Section = tuple[str, str]
"""Heading and content, which is HTML."""


def page(title: str, lead: str, sections: Sequence[Section]) -> str:
    """The whole page; `title` and headings are text, `lead` and contents HTML."""
    links = "".join(f'<li><a href="#s{i}">{escape(name)}</a></li>' for i, (name, _) in enumerate(sections, 1))
    bodies = "".join(
        f'<section id="s{i}"><h2>{i}. {escape(name)}</h2>{body}</section>' for i, (name, body) in enumerate(sections, 1)
    )
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{_STYLE}</style></head>'
        f"<body><main><h1>{escape(title)}</h1>{lead}<nav><ol>{links}</ol></nav>{bodies}</main></body></html>\n"
    )


def figure_html(number: int, name: str, title: str, caption: str, svg: bytes) -> str:
    """A figure with its picture inline. As an image of its own, nothing in it can clash with the page."""
    source = base64.b64encode(svg).decode()
    return (
        f'<figure><img alt="{escape(title)}" src="data:image/svg+xml;base64,{source}">'
        f"<figcaption><b>Figure {number}. {escape(title)}.</b> {escape(caption)} "
        f"<small>figures/{escape(name)}.png, .svg</small></figcaption></figure>"
    )


_STYLE = """
:root { color-scheme: light; }
body { margin: 0; background: #fff; color: #222; font: 18px/1.5 "Helvetica Neue", Arial, sans-serif; }
main { max-width: 1320px; margin: 0 auto; padding: 24px 32px 64px; }
h1 { font-size: 34px; line-height: 1.2; margin: 8px 0 12px; }
h2 { font-size: 27px; margin: 56px 0 12px; padding-top: 12px; border-top: 2px solid #222; }
h3 { font-size: 21px; margin: 32px 0 4px; }
p, li { max-width: 62em; }
a { color: #00558c; }
nav ol { columns: 2; padding-left: 1.4em; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 10px 0 8px; font-size: 16px; font-variant-numeric: tabular-nums;
  border-top: 2px solid #222; border-bottom: 2px solid #222; }
th, td { padding: 4px 11px; text-align: right; white-space: nowrap; vertical-align: baseline; }
thead th { border-bottom: 1px solid #222; vertical-align: bottom; }
th.method, thead th:first-child { text-align: left; padding-left: 4px; }
th.method { font-weight: 600; }
tbody + tbody { border-top: 1px solid #bbb; }
table.text th, td.text { text-align: left; white-space: normal; }
td.variant { text-align: left; color: #555; }
td.none { color: #777; font-style: italic; white-space: normal; text-align: right; }
td.none[colspan] { text-align: center; }
tr.paper td { color: #00558c; background: #f1f6fa; }
.half, td.printed::after { color: #666; font-size: 13.5px; }
td.printed::after { content: " ± 0.000"; visibility: hidden; } /* so that the paper's digits stand above ours */
.failed { display: block; color: #a33000; font-size: 13.5px; }
table.scores { width: 100%; font-size: 17px; }
.mark { position: absolute; }
.note { font-size: 16px; margin-top: 4px; }
figure { margin: 28px 0; }
img { width: 100%; height: auto; display: block; }
figcaption { font-size: 16px; margin-top: 6px; max-width: 70em; }
small { color: #666; font-size: 13.5px; }
@media print {
  @page { size: A4; margin: 12mm; }
  body { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  h1 { font-size: 18pt; } h2 { font-size: 14pt; margin-top: 18pt; } h3 { font-size: 11.5pt; }
  h2, h3, .before { break-after: avoid; }
  nav { display: none; }
  section + section { break-before: page; }
  .wide { overflow: visible; break-inside: avoid; }
  table { font-size: 8pt; }
  th, td { padding: 2px 5px; }
  table.scores { font-size: 8pt; }
  .scores .half { display: block; }
  td.printed::after { display: none; }
  tr.paper td { print-color-adjust: exact; }
  figure { break-inside: avoid; margin: 10pt 0; }
  img { max-height: 225mm; object-fit: contain; }
  figcaption, .note { font-size: 8.5pt; } small, .half, .failed { font-size: 7.5pt; }
}
"""
