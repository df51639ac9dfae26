"""What viser cannot be told from Python, done by the page itself: opening tabs, and keys that also move the camera.

viser shows HTML as it is, so a picture that cannot be loaded runs what stands in its ``onerror``, once.
"""

from __future__ import annotations

import html
import json

_OPEN = """{
  const [name, atEnd] = [%s, %s];
  const find = () => [...document.querySelectorAll('[role=tab]')].find(tab => tab.textContent.trim() === name);
  const groupOf = part => part?.closest?.('[data-dock-group]');
  const opened = find();
  opened?.click();
  opened?.dispatchEvent(new KeyboardEvent('keydown', {key: 'Enter', bubbles: true}));
  window.stopScrolling?.();
  const over = new AbortController();
  const stop = window.stopScrolling = () => { clearInterval(scrolling); over.abort(); };
  let times = atEnd ? 20 : 1;
  const scrolling = setInterval(() => {
    if (document.querySelector('#ido-splash:not(.gone)')) return;
    const tab = find();
    if (tab?.ariaSelected !== 'true' || --times < 0) return stop();
    const areas = [...groupOf(tab)?.querySelectorAll('.mantine-ScrollArea-viewport') ?? []];
    const shown = areas.find(area => area.clientHeight > 0);
    shown?.scrollTo({top: atEnd ? shown.scrollHeight : 0});
  }, 300);
  const touched = ({target}) => groupOf(target) === groupOf(find()) && stop();
  for (const kind of ['wheel', 'pointerdown']) addEventListener(kind, touched, {capture: true, signal: over.signal});
}"""
"""A docked tab takes the key Enter, one on a phone the click. What a tab holds comes a while after it was opened, so
its end is gone to for six seconds, or until a person touches it; another tab that was opened meanwhile stays put."""

_ARROWS = """window.lessonKeys ??= (window.addEventListener('keydown', event => {
  const key = {ArrowLeft: 'PageUp', ArrowRight: 'PageDown'}[event.key];
  if (!key || event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return;
  if (!document.querySelector('.lesson')) return;
  if (event.target.closest?.('input, textarea, [role=slider], [role=tab], [role=dialog]')) return;
  event.stopPropagation();
  event.preventDefault();
  event.target.dispatchEvent(new KeyboardEvent('keydown', {key, code: key, bubbles: true}));
}, true), true)"""
"""While a lesson is shown, the arrows are the keys of a clicker; sliders, tabs and fields keep them."""


_NOTE_TABS = """window.tabsBefore ??=
  [...document.querySelectorAll('[role=tab][aria-selected=true]')].map(tab => tab.textContent.trim());"""
_TABS_BEFORE = """for (const tab of document.querySelectorAll('[role=tab][aria-selected=false]')) {
  if (!window.tabsBefore?.includes(tab.textContent.trim())) continue;
  tab.click();
  tab.dispatchEvent(new KeyboardEvent('keydown', {key: 'Enter', bubbles: true}));
}
window.tabsBefore = undefined;"""


def note_tabs() -> str:
    """HTML that notes which tabs are open, unless some are noted already."""
    return _run(_NOTE_TABS, 0)


def tabs_before(turn: int) -> str:
    """HTML that opens the noted tabs again, once; another `turn` does it again."""
    return _run(_TABS_BEFORE, turn)


def open_tab(name: str, turn: int, *, at_end: bool) -> str:
    """HTML that opens a tab by its name, at its start or its end; another `turn` opens it again."""
    return _run(_OPEN % (json.dumps(name), json.dumps(at_end)), turn)


def arrows_turn_pages() -> str:
    """HTML that gives the left and right arrow the meaning of the keys PageUp and PageDown."""
    return _run(_ARROWS, 0)


def _run(script: str, turn: int) -> str:
    return f'<img alt="" hidden data-turn="{turn}" src="data:," onerror="{html.escape(script)}">'
