"""The four tables of results that the paper prints, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

PAPER_METHODS = ("BCPD", "CPD", "GMMReg", "ICP", "KCCE", "DO", "Improved DO")
"""The columns of the paper's tables. The paper calls Improved DO "OURS"."""

ROW_NAMES: dict[str, str] = {
    "noise": "NoiseStd",
    "outliers": "Outliers",
    "points": "PointNum",
    "incomplete": "Incomplete",
    "rotation": "Rotation",
    "translation": "Translation",
}
"""Each sweep and what the paper calls it, in the order of its tables and figures."""

SCORE_TITLES: dict[str, str] = {"accuracy": "PointAcc", "rmse": "PointRMSE"}
"""Each score of the tables, a column of `Results`, and what the paper calls it."""

COMPARED_MAPS = (1, 15, 30)
"""Numbers of the maps that its figure of learned maps compares."""

PAPER_SCENES = 100
"""Scenes at each level of the paper's sweeps."""


@dataclass(frozen=True, slots=True)
class PaperTable:
    """One printed table: the mean score of every method over each sweep.

    Args:
        number: as printed.
        caption: as printed.
        dataset: our name of the shape.
        score: ``accuracy`` or ``rmse``.
        values: by sweep and method.
        repeated: sweeps whose row the paper prints in another table, too: its slip.
    """

    number: str
    caption: str
    dataset: str
    score: str
    values: Mapping[str, Mapping[str, float]]
    repeated: tuple[str, ...] = ()


def _values(*rows: tuple[float, ...]) -> dict[str, dict[str, float]]:
    return {sweep: dict(zip(PAPER_METHODS, row, strict=True)) for sweep, row in zip(ROW_NAMES, rows, strict=True)}


PAPER_TABLES: tuple[PaperTable, ...] = (
    PaperTable(
        "I",
        "Average PointAcc on Synthetic Dataset",
        "bunny",
        "accuracy",
        _values(
            (0.650, 0.333, 0.100, 0.000, 0.000, 0.863, 0.990),
            (0.683, 0.326, 0.129, 0.000, 0.000, 0.889, 0.994),
            (0.700, 0.494, 0.104, 0.000, 0.000, 0.866, 0.944),
            (0.643, 0.295, 0.093, 0.000, 0.000, 0.855, 0.955),
            (0.380, 0.176, 0.093, 0.001, 0.123, 0.487, 0.621),
            (0.662, 0.242, 0.102, 0.000, 0.000, 0.545, 0.755),
        ),
    ),
    PaperTable(
        "II",
        "Average PointRMSE on Synthetic Dataset",
        "bunny",
        "rmse",
        _values(
            (0.266, 0.454, 0.607, 1.086, 0.609, 0.098, 0.026),
            (0.242, 0.482, 0.590, 1.102, 0.614, 0.087, 0.024),
            (0.253, 0.383, 0.599, 1.125, 0.607, 0.100, 0.062),
            (0.301, 0.528, 0.612, 1.071, 0.631, 0.105, 0.047),
            (0.676, 0.807, 0.802, 1.118, 0.802, 0.576, 0.464),
            (0.291, 0.609, 0.751, 1.270, 0.708, 0.405, 0.273),
        ),
    ),
    PaperTable(
        "III",
        "Average PointAcc on Real Dataset",
        "urban",
        "accuracy",
        _values(
            (0.743, 0.383, 0.020, 0.000, 0.003, 0.777, 0.993),
            (0.789, 0.369, 0.049, 0.000, 0.011, 0.783, 0.991),
            (0.728, 0.516, 0.052, 0.000, 0.004, 0.808, 0.952),
            (0.718, 0.328, 0.055, 0.000, 0.005, 0.743, 0.953),
            (0.417, 0.176, 0.084, 0.000, 0.175, 0.404, 0.648),
            (0.662, 0.242, 0.102, 0.000, 0.000, 0.545, 0.755),
        ),
        repeated=("translation",),
    ),
    PaperTable(
        "IV",
        "Average PointRMSE on Real Dataset",
        "urban",
        "rmse",
        _values(
            (0.217, 0.400, 0.641, 1.122, 0.494, 0.132, 0.024),
            (0.177, 0.414, 0.627, 1.128, 0.495, 0.132, 0.020),
            (0.237, 0.343, 0.619, 1.144, 0.497, 0.130, 0.045),
            (0.242, 0.420, 0.637, 1.128, 0.515, 0.169, 0.049),
            (0.635, 0.754, 0.793, 1.154, 0.757, 0.626, 0.430),
            (0.291, 0.609, 0.751, 1.270, 0.708, 0.405, 0.273),
        ),
        repeated=("translation",),
    ),
)
"""Tables I to IV. Each sweep is a row, in the order of `ROW_NAMES`."""
