"""All text on the page can be read, in light and dark."""

from __future__ import annotations

import pytest
from explorer import TABS, Explorer

READABLE = 4.5  # WCAG 2.2, AA

HARD_TO_READ = """least => {
    const paint = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
    const rgba = css => {
        paint.clearRect(0, 0, 1, 1);
        paint.fillStyle = css;
        paint.fillRect(0, 0, 1, 1);
        const [r, g, b, a] = paint.getImageData(0, 0, 1, 1).data;
        return [r, g, b, a / 255];
    };
    const over = (above, below, alpha) => below.map((value, i) => value + (above[i] - value) * alpha);
    const behind = element => {
        if (!element) return [255, 255, 255];
        const [r, g, b, a] = rgba(getComputedStyle(element).backgroundColor);
        return a > 0.99 ? [r, g, b] : over([r, g, b], behind(element.parentElement), a);
    };
    const opacity = element => element ? Number(getComputedStyle(element).opacity) * opacity(element.parentElement) : 1;
    const luminance = color => color
        .map(value => value / 255)
        .map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
        .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
    const texts = [...document.querySelectorAll("input:not([type=checkbox])")].map(input => [input, input.value]);
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) texts.push([walker.currentNode.parentElement, walker.currentNode.data]);
    return texts
        .filter(([element, text]) => /[\\p{L}\\p{N}]/u.test(text)
            && element.checkVisibility({opacityProperty: true, visibilityProperty: true})
            && element.getBoundingClientRect().width > 1
            && !element.closest("style, script, :disabled, [data-disabled], [aria-disabled=true]"))
        .map(([element, text]) => {
            const [r, g, b, a] = rgba(getComputedStyle(element).color);
            const page = behind(element);
            const ink = over([r, g, b], page, a * opacity(element));
            const [low, high] = [luminance(ink), luminance(page)].sort((one, other) => one - other);
            return [(high + 0.05) / (low + 0.05), ink.map(Math.round), page.map(Math.round), text.trim().slice(0, 40),
                `${element.tagName}.${element.className}`];
        })
        .filter(([contrast]) => contrast < least);
}"""
"""Each visible text with too little contrast to what is behind it, with both colours and where it is."""

CHART_TABS = (
    "Training",
    "Derivations",
    "Help",
    "Histograms",
    "Errors",
    "Compare",
    "Basin",
    "Sweeps",
    "Inspect",
    "Maps",
)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_all_text_can_be_read(explorer: Explorer, dark: bool):
    if dark:
        explorer.tick("Dark")
        explorer.page.locator("[data-mantine-color-scheme=dark]").wait_for()
    found, hard = [], []
    for tab in (*TABS, *CHART_TABS):
        explorer.open_tab(tab)
        for _ in range(20):  # a tab is drawn when it is opened, and colours fade over
            explorer.pause(150)
            hard = explorer.page.evaluate(HARD_TO_READ, READABLE)
            if not hard:
                break
        found += [[tab, *text] for text in hard]
    assert found == []
