"""The shipped results of the paper's experiments: means over a sweep, and the state of every scene behind them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ido import Perturbation
from ido.experiments import LEVELS, Results, level_scene
from ido.experiments.execution import MOST_SCENES, SEED
from ido.experiments.families import FAMILIES
from ido.methods import method_names
from ido.results import ResultsError
from ido.shipped import SHAPES, shipped_results
from ido_viz.core.state import LAST, NO_START, State

SCORES = {"PointAcc": "accuracy", "PointRMSE": "rmse"}
_MAIN = frozenset(family.main for family in FAMILIES)
_DELIVERED = frozenset(dict(family.variants).get("default", family.main) for family in FAMILIES)
GROUPS: dict[str, Callable[[str], bool]] = {
    "one of each, tuned": _MAIN.__contains__,
    "one of each, by default": _DELIVERED.__contains__,
    "all variants": lambda method: True,
}
"""Whose curves can be drawn together; in the first two each has a colour of its own."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A registration of the shipped results."""

    shape: str
    sweep: str
    level: float
    trial: int
    method: str

    def at(self, state: State) -> State:
        """The state that shows it, at its end: in the right pane, unless its method is in the left one already."""
        base, default = Perturbation(outlier_kind=SHAPES[self.shape].outlier_kind), State()
        is_left = self.method == state.left
        others = (state.right if is_left else state.left, default.left, default.right)
        other = next(method for method in others if method != self.method and method in method_names(self.shape))
        return replace(
            state,
            epsilon=default.epsilon,
            max_iterations=default.max_iterations,
            shape=self.shape,
            perturbation=level_scene(base, self.sweep, self.level, self.trial, MOST_SCENES, SEED),
            left=self.method if is_left else other,
            right=other if is_left else self.method,
            start=NO_START,
            iteration=LAST,
            playing=False,
            inside=0.0,
        )


def rows_of(shape: str, sweep: str) -> tuple[Results, str]:
    """The shipped results of a sweep, of the methods that were run on all scenes; and why there are none."""
    none = Results(*(np.zeros(0) for _ in fields(Results)))
    if shape not in SHAPES:
        return none, "There are results of the shipped shapes only."
    try:
        rows = shipped_results().where(dataset=shape, sweep=sweep)
    except ResultsError as error:  # the rest of the page does without them
        return none, f"The results cannot be read: {error}"
    names, counts = np.unique(rows.method, return_counts=True)
    return rows.among(method=names[counts == len(LEVELS[sweep]) * MOST_SCENES].tolist()), ""


def mean_scores(rows: Results, method: str, score: str, levels: Sequence[float]) -> np.ndarray:
    """Mean score of a method at each level, failed registrations left out, shape (levels,); NaN where there is none."""
    own = rows.where(method=method)
    values = [getattr(own, score)[own.level == level] for level in levels]
    return np.array([np.nanmean(found) if np.isfinite(found).any() else np.nan for found in values])


def scene_labels(rows: Results, method: str, level: float) -> list[str]:
    """The scenes of a method at a level, worst first: number and PointAcc."""
    own = rows.where(method=method, level=level)
    order = np.lexsort((own.trial, own.accuracy))
    return [f"{own.trial[i]} (PointAcc {own.accuracy[i]:.2f})" for i in order] or ["–"]
