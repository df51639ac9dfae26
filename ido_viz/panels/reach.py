"""What the shown maps were trained on, and what of the scene lies beyond it."""

from __future__ import annotations

from ido import Maps
from ido_viz.core.frame import Frame
from ido_viz.core.run import start_size
from ido_viz.core.state import State
from ido_viz.panels.markup import caption

_SLACK = 1e-9  # what sliders' rounding may add


def reach_html(frame: Frame) -> str:
    """The range of both sides' maps, or what of the scene lies beyond; nothing where no maps are shown.

    One line for either, so that what stands below stays in its place while a slider is dragged.
    """
    trained = [side.run.maps for side in frame.sides if side.run.maps is not None]
    if not trained:
        return ""
    found = dict.fromkeys(text for maps in trained for text in beyond(maps, frame.state))
    if found:
        return caption(f"<b>Beyond training:</b> {', '.join(found)}")
    ends = [f"{maps.settings.rotation:g}° and {maps.settings.translation:g}" for maps in trained]
    return caption(f"Trained on turns and shifts of up to {' or '.join(dict.fromkeys(ends))}.")


def beyond(maps: Maps, state: State) -> list[str]:
    """Which of a scene's values lie outside what maps were trained on, and where."""
    ranges = maps.settings.ranges
    values = {name: getattr(state.perturbation, name) for name in ranges}
    values["rotation"], values["translation"] = start_size(state)
    return [
        f"{name} {_number(values[name])} {'>' if values[name] > high else '<'} {high if values[name] > high else low:g}"
        for name, (low, high) in ranges.items()
        if not low - _SLACK <= values[name] <= high + _SLACK
    ]


def _number(value: float) -> str:
    """Whole, or in three digits."""
    return f"{value:.0f}" if value == int(value) else f"{value:.3g}"
