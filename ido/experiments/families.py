"""The methods as the report groups and draws them: each with its variants, a colour and a marker of its own."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ido.methods import FROM_ANY_START, LEARNED, MANY_STARTS


@dataclass(frozen=True, slots=True)
class Family:
    """One of the compared methods, with all its variants.

    Args:
        title: as it is shown.
        paper: what the paper's tables call it; None if they do not have it.
        variants: what each variant is called in the report, and its method name in `ido.methods`; the main one first.
        color: of Okabe and Ito's, which people with any colour vision tell apart; purple for their green, which
            stands for the true place.
        marker: of Matplotlib.
    """

    title: str
    paper: str | None
    variants: tuple[tuple[str, str], ...]
    color: str
    marker: str

    @property
    def main(self) -> str:
        """The method name of the main variant: the tuned one, where there are two settings."""
        return self.variants[0][1]


def _two_settings(title: str, paper: str | None, color: str, marker: str) -> Family:
    variants = tuple((setting, f"{title}, {setting}") for setting in ("tuned", "default"))
    return Family(title, paper, variants, color, marker)


def _learned(title: str, color: str, marker: str) -> Family:
    """A learned method with its variants, ``Title (variant)``."""
    many = tuple((name.removeprefix(f"{title}, "), name) for name, one in MANY_STARTS.items() if one == title)
    return Family(title, title, (("here", title), *_in_brackets(title, LEARNED), *many), color, marker)


def _in_brackets(title: str, names: Iterable[str]) -> tuple[tuple[str, str], ...]:
    """The variants that are called ``Title (variant)``."""
    return tuple((n.removeprefix(f"{title} (").rstrip(")"), n) for n in names if n.startswith(f"{title} ("))


LEARNED_FAMILIES: tuple[Family, ...] = (_learned("DO", "#0072B2", "o"), _learned("Improved DO", "#D55E00", "s"))

BASELINE_FAMILIES: tuple[Family, ...] = (
    _two_settings("BCPD", "BCPD", "#7B3FA0", "D"),
    _two_settings("CPD", "CPD", "#56B4E9", "^"),
    _two_settings("GMMReg", "GMMReg", "#CC79A7", "v"),
    _two_settings("ICP", "ICP", "#E69F00", "X"),
    _two_settings("KCCE (reconstruction)", "KCCE", "#000000", "P"),
)

GLOBAL = Family("Global", None, (("here", "Global"), *_in_brackets("Global", FROM_ANY_START)), "#8C4A2F", "*")

PEER_FAMILIES: tuple[Family, ...] = (
    _two_settings("Open3D RANSAC", None, "#332288", "<"),
    _two_settings("Open3D FGR", None, "#DDCC77", ">"),
    _two_settings("small_gicp", None, "#882255", "h"),
    _two_settings("KISS-Matcher", None, "#6B8E9E", "p"),
)

NOTHING = Family("Did nothing", None, (("here", "Did nothing"),), "#777777", "")

FAMILIES: tuple[Family, ...] = (*LEARNED_FAMILIES, *BASELINE_FAMILIES, GLOBAL, *PEER_FAMILIES, NOTHING)
"""All of them, in the order of the report."""

COMPARED_METHODS: tuple[str, ...] = tuple(method for family in FAMILIES for _, method in family.variants)
"""The names of all methods, in the order of the report."""
