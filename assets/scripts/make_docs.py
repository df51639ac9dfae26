"""Write what the documents take from the code and the results: `python assets/scripts/make_docs.py`.

A part stands between ``<!-- begin NAME -->`` and ``<!-- end NAME -->`` in a file of `assets/docs`; what is there is
replaced. It needs no network. Run it after a new block, histogram or method, and after new results.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from ido import HISTOGRAMS, RANGES, SHAPES, Histogram, Perturbation, shipped_maps, shipped_results
from ido.blocks import Block
from ido.experiments import LEVELS, Results
from ido.experiments.beyond import BEYOND
from ido.experiments.estimates import Costs, Estimate, estimate, sweep_estimate
from ido.experiments.families import BASELINE_FAMILIES, FAMILIES, NOTHING, PEER_FAMILIES, Family
from ido.experiments.paper import PAPER_TABLES, ROW_NAMES, SCORE_TITLES
from ido.experiments.report_tables import reliabilities
from ido.methods import BASELINES, FROM_ANY_START, LEARNED, MANY_STARTS, PEERS, method_names
from ido.shipped import shipped_histograms

DOCS = Path(__file__).parents[1] / "docs"

PAIRS = (
    ("bunny", "Improved DO", "DO"),
    ("bunny", "Improved DO (near / far)", "Improved DO"),
    ("bunny", "Improved DO (near / far)", "DO"),
    ("bunny", "Improved DO (as printed)", "DO"),
    ("urban", "Improved DO", "DO"),
)
"""A shape, and two methods whose scores are compared scene by scene."""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table; bars within a cell are kept from ending it."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines)


def first_sentence(documented: type) -> str:
    """Of a class's docstring, in one line."""
    text = " ".join((inspect.getdoc(documented) or "").split())
    return re.split(r"(?<=\.) ", text, maxsplit=1)[0]


# the methods


def blocks() -> str:
    """Every block of the histograms that the program knows, each once."""
    found: dict[str, Block] = {block.name: block for histogram in HISTOGRAMS.values() for block in histogram.blocks}
    rows = []
    for name, block in found.items():
        having = [histogram for histogram in HISTOGRAMS.values() if name in [b.name for b in histogram.blocks]]
        methods = [method for histogram in having for method in _methods_of(histogram)]
        rows.append(
            (
                f"`{type(block).__name__}`",
                name,
                ", ".join(f"`{histogram.name}`" for histogram in having),
                ", ".join(methods),
                first_sentence(type(block)),
            )
        )
    return table(("block", "sides", "histograms", "methods", "first side, and how a point counts"), rows)


def histograms() -> str:
    """Every histogram, its blocks and what ships for it."""
    rows = []
    for histogram in HISTOGRAMS.values():
        shapes = [shape for shape in SHAPES if histogram.name in shipped_histograms(shape)]
        errors = [f"{shape} {shipped_maps(shape, histogram.name).curves.mean[-1]:.4f}" for shape in shapes]
        rows.append(
            (
                f"`{histogram.name}`",
                ", ".join(_methods_of(histogram)),
                "; ".join(block.name for block in histogram.blocks),
                str(2 * len(histogram.blocks)),
                ", ".join(errors),
            )
        )
    return table(("histogram", "method", "blocks", "bins per model point", "training error after the last map"), rows)


def settings() -> str:
    """All settings of the baselines."""
    rows = []
    for family in BASELINE_FAMILIES:
        default, tuned = (BASELINES[f"{family.title}, {setting}"].settings for setting in ("default", "tuned"))
        for name in default:
            values = (_plain(default[name]), _plain(tuned[name]))
            rows.append((family.title, f"`{name}`", values[0], values[1] if values[1] != values[0] else "the same"))
    return table(("method", "setting", "default", "tuned"), rows)


def _methods_of(histogram: type[Histogram]) -> list[str]:
    return [method for method, name in LEARNED.items() if name == histogram.name]


def _plain(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


# the results


def _of_the_paper() -> Results:
    """The results of the methods that walk from where the scene lies, in the paper's sweeps."""
    return shipped_results().among(sweep=LEVELS, method={name for shape in SHAPES for name in method_names(shape)})


def extent() -> str:
    """How many registrations there are, and how sure their means."""
    results = _of_the_paper()
    halves = {
        (shape, method): max(
            _sweeps(results.where(dataset=shape, method=method), "accuracy"), key=lambda e: e.half
        ).half
        for shape in SHAPES
        for method in _run_on(results, shape)
    }
    learned = max(half for (shape, method), half in halves.items() if shape == "bunny" and method in LEARNED)
    scenes = sorted(
        {count for e in _sweeps(results.where(dataset="bunny", method="DO"), "accuracy") for count in e.scenes}
    )
    return (
        f"There are {len(results):,} registrations: six sweeps, {' to '.join(map(str, scenes))} scenes at each level, "
        f"seeds from {results.seed.min():,}.\n"
        f"95% confidence intervals of the means of PointAcc are within ± {_up(learned)} for the learned methods on the "
        f"bunny and within ± {_up(max(halves.values()))} everywhere."
    )


def levels() -> str:
    """The sweeps' levels."""
    rows = [
        (name, RANGES[name].unit, ", ".join(f"{level:g}" for level in at), f"{getattr(Perturbation(), name):g}")
        for name, at in LEVELS.items()
    ]
    return table(("sweep", "unit", "levels", "in the other sweeps"), rows)


def summary() -> str:
    """The mean PointAcc over all sweeps, and the time of one registration."""
    results = _of_the_paper()
    rows = []
    for family in FAMILIES:
        tuned = family in BASELINE_FAMILIES
        for variant, method in family.variants[:1] if tuned else family.variants:
            if not len(results.where(method=method)):
                continue
            cells = []
            for shape in SHAPES:
                cells.append(_papers_mean(shape, family) if method == family.main else "")
                settings = (f"{family.title}, default", method) if tuned else (method, None)
                cells += [_mean_of_sweeps(results, shape, name) for name in settings]
            seconds = Costs.of(results.where(dataset="bunny", method=method)).seconds
            shown = f"{seconds * 1e3:.0f} ms" if family is not NOTHING else ""
            rows.append((family.title if tuned or variant == "here" else method, *cells, shown))
    head = ("method", *(f"{shape}: {what}" if what == "paper" else what for shape in SHAPES for what in _COLUMNS))
    return table((*head, "time"), rows)


_COLUMNS = ("paper", "default", "tuned")


def scores(shape: str, score: str) -> Callable[[], str]:
    """Makes the table of one score of each sweep on one shape, with the paper's figures in brackets."""

    def make() -> str:
        results = _of_the_paper().where(dataset=shape)
        printed = next(t for t in PAPER_TABLES if (t.dataset, t.score) == (shape, score)).values
        rows = []
        for family in FAMILIES:
            for _, method in family.variants[:1] if family in BASELINE_FAMILIES else family.variants:
                run = results.where(method=method)
                if not len(run):
                    continue
                has_paper = family.paper is not None and method == family.main
                cells = []
                for sweep in LEVELS:
                    found = sweep_estimate(run, sweep, score)
                    papers = f" ({printed[sweep][family.paper]:.3f})" if family.paper and has_paper else ""
                    cells.append(f"{found.mean:.3f} ± {found.half:.3f}{papers}")
                rows.append((method, *cells))
        return table((shape, *LEVELS), rows)

    return make


def pairs() -> str:
    """Differences of two methods on the same scenes, in PointAcc."""
    rows = []
    for shape, method, other in PAIRS:
        found = paired(shipped_results().where(dataset=shape), method, other)
        mean = np.mean([each.mean for each in found.values()])
        half = np.sqrt(sum(each.half**2 for each in found.values())) / len(found)
        cells = [_signed(each.mean, each.half) for each in found.values()]
        rows.append((shape, f"{method} - {other}", *cells, _signed(float(mean), float(half))))
    return table(("cloud", "difference", *LEVELS, "mean"), rows)


def paired(results: Results, method: str, other: str) -> dict[str, Estimate]:
    """The mean difference in PointAcc, method - other, over each sweep of one shape, scene by scene."""
    found = {}
    for sweep, at in LEVELS.items():
        differences = []
        for level in at:
            a, b = (results.where(method=name, sweep=sweep, level=level) for name in (method, other))
            seeds = np.intersect1d(a.seed, b.seed)
            if not len(seeds) == len(a) == len(b):
                raise ValueError(f"{method} and {other} met other scenes at {sweep} {level:g}")
            differences.append(a.accuracy[np.argsort(a.seed)] - b.accuracy[np.argsort(b.seed)])
        found[sweep] = estimate(differences)
    return found


def global_table(sweeps: Iterable[str]) -> Callable[[], str]:
    """Makes the table of the methods from any start, the polished ones and the peers, with DO and ICP to compare."""

    def make() -> str:
        results = shipped_results().among(sweep=list(sweeps))
        rows = []
        for shape in SHAPES:
            for method in GLOBAL_ROWS:
                run = results.where(dataset=shape, method=method)
                found = [sweep_estimate(run, sweep, "accuracy") for sweep in sweeps]
                if not len(run):
                    continue
                counts = sorted({count for each in found for count in each.scenes})
                scenes = " to ".join(f"{count}" for count in (counts[0], *counts[1:][-1:]))
                cells = (f"{each.mean:.3f} ± {each.half:.3f}" if each.status == "run" else "" for each in found)
                rows.append((shape, method, scenes, *cells, f"{Costs.of(run).seconds * 1e3:.0f} ms"))
        return table(("cloud", "method", "scenes", *sweeps, "CPU time"), rows)

    return make


GLOBAL_ROWS = (
    *("DO", "DO, polished", "Improved DO", "Improved DO, polished", "ICP, tuned", "ICP, tuned, polished"),
    *FROM_ANY_START,
    *MANY_STARTS,
    *(f"{family.title}, {setting}" for family in PEER_FAMILIES for setting in ("default", "tuned")),
)
"""The methods of the tables of global.md."""


def reliability() -> str:
    """How well the probabilities agree with what was right."""
    rows = []
    for method, its in reliabilities(shipped_results()).items():
        (sure, sure_right), (wrong, doubted) = its.sure, its.failures
        rows.append(
            (
                *(method, f"{its.total:,}", f"{its.share_right:.3f}", f"{its.error:.3f}"),
                *(f"{sure_right} of {sure}", f"{doubted} of {wrong}"),
            )
        )
    return table(("method", "poses", "right", "ECE", "right, of p ≥ 0.95", "p < 0.5, of wrong ones"), rows)


def peer_settings() -> str:
    """All settings of the peers."""
    rows = []
    for family in PEER_FAMILIES:
        default, tuned = (PEERS[f"{family.title}, {setting}"].settings for setting in ("default", "tuned"))
        rows += [
            (family.title, f"`{name}`", str(value), str(tuned[name]) if tuned[name] != value else "the same")
            for name, value in default.items()
        ]
    return table(("method", "setting", "default", "tuned"), rows)


def _run_on(results: Results, shape: str) -> list[str]:
    here = set(results.where(dataset=shape).method.tolist())
    return [method for method in method_names(shape) if method in here]


def _sweeps(run: Results, score: str) -> list[Estimate]:
    return [sweep_estimate(run, sweep, score) for sweep in LEVELS]


def _mean_of_sweeps(results: Results, shape: str, method: str | None) -> str:
    run = results.where(dataset=shape, method=method or "")
    return f"{np.mean([each.mean for each in _sweeps(run, 'accuracy')]):.3f}" if len(run) else ""


def _papers_mean(shape: str, family: Family) -> str:
    if family.paper is None:
        return ""
    printed = next(t for t in PAPER_TABLES if (t.dataset, t.score) == (shape, "accuracy")).values
    return f"{np.mean([printed[sweep][family.paper] for sweep in ROW_NAMES]):.3f}"


def _signed(mean: float, half: float) -> str:
    return f"{mean:+.3f} ± {half:.3f}"


def _up(half: float) -> str:
    """Rounded up to three digits, so that "within" stays true."""
    return f"{np.ceil(half * 1000) / 1000:.3f}"


PARTS: dict[str, Callable[[], str]] = {
    "blocks": blocks,
    "histograms": histograms,
    "settings": settings,
    "extent": extent,
    "levels": levels,
    "summary": summary,
    **{f"{shape}-{score}": scores(shape, score) for shape in SHAPES for score in SCORE_TITLES},
    "pairs": pairs,
    "global-sweeps": global_table(LEVELS),
    "global-beyond": global_table(BEYOND),
    "reliability": reliability,
    "peer-settings": peer_settings,
}
"""What makes each part, by its name."""

_PART = re.compile(r"<!-- begin (?P<name>\S+) -->\n.*?<!-- end (?P=name) -->", re.DOTALL)


def written(text: str) -> str:
    """A document with all its parts made anew.

    Raises:
        KeyError: a part has an unknown name.
    """
    return _PART.sub(lambda found: _marked(found["name"]), text)


def _marked(name: str) -> str:
    return f"<!-- begin {name} -->\n{PARTS[name]()}\n<!-- end {name} -->"


def main() -> None:
    """Write all documents, and say which changed."""
    for path in sorted(DOCS.glob("*.md")):
        before = path.read_text(encoding="utf-8")
        after = written(before)
        if after != before:
            path.write_text(after, encoding="utf-8")
            print(f"{path.name} changed", file=sys.stderr)


if __name__ == "__main__":
    main()
