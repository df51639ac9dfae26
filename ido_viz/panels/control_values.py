"""A state as the values of its widgets, and the values of widgets as a state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar

from ido import RANGES, Perturbation
from ido.perturbation import LARGEST_SEED
from ido_viz.core.library import Library
from ido_viz.core.run import start_size
from ido_viz.core.state import EPSILON_RANGE, LONGEST_RUN, NO_START, State

STEPS = {"noise": 0.001, "points": 10, "outliers": 10, "incomplete": 0.01, "rotation": 1.0, "translation": 0.01}
"""Of the sliders."""

_AS_IN_THE_STATE = (
    "shape",
    "left",
    "right",
    "epsilon",
    "max_iterations",
    "speed",
    "replay",
    "handles",
    "order",
    "difference",
    "ghost",
    "error_vectors",
    "overlay",
    "overlaid_iteration",
    "dark",
    "large_text",
)


def values_of(state: State) -> dict[str, Any]:
    """What each widget holds for a state."""
    values: dict[str, Any] = {name: getattr(state.perturbation, name) for name in (*RANGES, "outlier_kind", "seed")}
    if state.start:
        for name, size in zip(("rotation", "translation"), start_size(state), strict=True):
            step, allowed = STEPS[name], RANGES[name]
            values[name] = round(min(max(round(size / step) * step, allowed.low), allowed.high), 6)
    values |= {name: getattr(state, name) for name in _AS_IN_THE_STATE}
    values["follow"] = state.pinned_map == 0
    if state.pinned_map:
        values["pinned_map"] = state.pinned_map
    return values


def with_values(state: State, value: Mapping[str, Any], library: Library, n_maps: int) -> State:
    """A state with what widgets hold; nonsense is brought into range.

    Args:
        state: what it is but for them.
        value: of each widget.
        library: shapes and methods on offer.
        n_maps: up to which one can be shown.
    """
    drawn, start = _start(value, state)
    perturbation = Perturbation(
        **{name: _within(drawn[name], r.low, r.high, getattr(Perturbation(), name)) for name, r in RANGES.items()},
        outlier_kind=value["outlier_kind"],
        seed=_within(value["seed"], 0, LARGEST_SEED, 0),
    )
    known_shapes = library.subjects
    shape = value["shape"] if value["shape"] in known_shapes else next(iter(known_shapes))  # it was deleted
    known = library.methods(shape)
    return replace(
        state,
        shape=shape,
        perturbation=perturbation,
        start=start,
        replay=value["replay"],
        handles=value["handles"],
        left=value["left"] if value["left"] in known else known[0],
        right=value["right"] if value["right"] in known else known[1],
        epsilon=_within(value["epsilon"], *EPSILON_RANGE, State().epsilon),
        max_iterations=_within(value["max_iterations"], 1, LONGEST_RUN, State().max_iterations),
        speed=_within(value["speed"], 1, 60, State().speed),
        order=value["order"],
        difference=value["difference"],
        pinned_map=0 if value["follow"] else _within(value["pinned_map"], 1, n_maps, 1),
        ghost=value["ghost"],
        error_vectors=value["error_vectors"],
        overlay=value["overlay"],
        overlaid_iteration=_within(value["overlaid_iteration"], 0, LONGEST_RUN, 0),
        dark=value["dark"],
        large_text=value["large_text"],
    )


def _start(value: Mapping[str, Any], state: State) -> tuple[Mapping[str, Any], tuple[float, ...]]:
    """What a scene is drawn from, and how it was moved by hand.

    While it is, the sliders show how far it is from where it belongs, and whoever moves one lets go of it.
    """
    if not state.start:
        return value, NO_START
    shown = values_of(state)
    if any(value[name] != shown[name] for name in ("rotation", "translation")):
        return value, NO_START
    p = state.perturbation
    return {**value, "rotation": p.rotation, "translation": p.translation}, state.start


Number = TypeVar("Number", int, float)


def _within(value: Any, low: float, high: float, default: Number) -> Number:
    """A number brought into a range, of the default's kind; the default if it is none at all."""
    if not isinstance(value, int | float) or not math.isfinite(value):
        return default
    return type(default)(min(max(value, low), high))
