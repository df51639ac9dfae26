"""The methods as the report groups and draws them: each with its variants, a colour and a marker of its own."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Family:
    """One of the compared methods, with all its variants.

    Args:
        title: as it is shown.
        paper: what the paper's tables call it; None if they do not have it.
        variants: what each variant is called in the report, and its method name in `ido.methods`; the main one first.
        color: of Okabe and Ito's, which people with any colour vision tell apart.
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


def _baseline(title: str, paper: str, color: str, marker: str) -> Family:
    variants = tuple((setting, f"{title}, {setting}") for setting in ("tuned", "default"))
    return Family(title, paper, variants, color, marker)


LEARNED_FAMILIES: tuple[Family, ...] = (
    Family("DO", "DO", (("here", "DO"),), "#0072B2", "o"),
    Family(
        "Improved DO",
        "Improved DO",
        (("here", "Improved DO"), ("as printed", "Improved DO (as printed)")),
        "#D55E00",
        "s",
    ),
)

BASELINE_FAMILIES: tuple[Family, ...] = (
    _baseline("BCPD", "BCPD", "#009E73", "D"),
    _baseline("CPD", "CPD", "#56B4E9", "^"),
    _baseline("GMMReg", "GMMReg", "#CC79A7", "v"),
    _baseline("ICP", "ICP", "#E69F00", "X"),
    _baseline("KCCE (reconstruction)", "KCCE", "#000000", "P"),
)

NOTHING = Family("Did nothing", None, (("here", "Did nothing"),), "#777777", "")

FAMILIES: tuple[Family, ...] = (*LEARNED_FAMILIES, *BASELINE_FAMILIES, NOTHING)
"""All of them, in the order of the report."""

METHODS: tuple[str, ...] = tuple(method for family in FAMILIES for _, method in family.variants)
"""The names of all methods, in the order of the report."""
