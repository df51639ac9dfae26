"""The report of an experiment: one page that needs nothing else, and its figures and tables as files."""

from __future__ import annotations

import csv
import importlib.metadata
import io
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ido.disk import write_whole
from ido.experiments.beyond import BEYOND
from ido.experiments.families import COMPARED_METHODS
from ido.experiments.paper import PAPER_SCENES, PAPER_TABLES, PaperTable
from ido.experiments.report_page import Section, figure_html, page
from ido.experiments.report_tables import (
    Row,
    beyond_table,
    costs_table,
    level_rows,
    levels_table,
    methods_of,
    reliabilities,
    reliability_rows,
    reliability_table,
    scenes_table,
    score_rows,
    score_table,
    settings_rows,
    settings_table,
)
from ido.experiments.sweeps import LEVELS
from ido.methods import LEARNED
from ido.results import Results
from ido.shipped import SHAPES, shipped_histograms, shipped_maps

if TYPE_CHECKING:
    from ido.experiments.gallery import NamedFigure

Settings = Mapping[tuple[str, str], Mapping[str, object]]
"""Settings of each (dataset, method), as recorded with the results."""

_KCCE = (
    "KCCE (reconstruction): neither code nor text of the paper's KCCE is public. Ours rebuilds the published idea; the "
    "paper's numbers beside it are those of the original."
)
_SLIP = (
    '<p class="note"><b>† The paper\'s slip:</b> in this table it prints the translation row of the bunny again '
    "(Table {other}), digit by digit. What it measured on its scan is not known.</p>"
)


def report_command(results: Path = Path("ido-results.sqlite"), output: Path = Path("ido-report")) -> None:
    """Write what an experiment found: a page, and its figures and tables as files.

    The page, report.html, holds the paper's four tables with the paper's numbers beside ours, and all figures. It is
    one file that opens offline, on a projector or printed. Besides, there are figures/ as PNG and SVG, and tables/ as
    CSV. A run that is not finished, or still going on, can be reported: what is missing says "not run".

    Args:
        results: What `ido experiment run` wrote.
        output: Folder to write to. Files of an earlier report are replaced.
    """
    from ido.experiments.store import Store

    with Store.view(results) as store:
        written = write_report(store.results(), output, store.methods())
    print(written)


def write_report(results: Results, folder: Path, settings: Settings) -> Path:
    """Write report.html, figures/ and tables/ to a folder, which is made if need be; returns the page's path.

    Args:
        results: what was found; may be any part of an experiment.
        folder: where to write.
        settings: of the methods, as they were when they were run.
    """
    (folder / "tables").mkdir(parents=True, exist_ok=True)
    (folder / "figures").mkdir(exist_ok=True)
    for name, rows in _csv_tables(results, settings):
        content = io.StringIO(newline="")
        csv.writer(content).writerows(rows)
        write_whole(folder / "tables" / f"{name}.csv", content.getvalue().encode())
    path = folder / "report.html"
    figures = _Figures(folder / "figures")
    sections = [
        *_results_sections(results, figures),
        *_beyond_sections(results),
        *_sure_sections(results, figures),
        *_method_sections(figures),
        *_run_sections(results, settings),
    ]
    write_whole(path, page("Registration with DO and Improved DO: results", _lead(results), sections).encode())
    return path


class _Figures:
    """Writes figures and numbers them, in the order of the page."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._written = 0

    def html(self, figures: Iterable[NamedFigure]) -> str:
        """Write each as files; returns them for the page."""
        from ido.experiments.figures import write_figure

        parts = []
        for named in figures:
            self._written += 1
            svg = write_figure(named.figure, self._folder / named.name)
            parts.append(figure_html(self._written, named.name, named.title, named.caption, svg))
        return "".join(parts)


def _csv_tables(results: Results, settings: Settings) -> Iterator[tuple[str, Iterable[Row]]]:
    for table in PAPER_TABLES:
        yield f"{table.dataset}-{table.score}", score_rows(results, table)
    yield "levels", level_rows(results)
    yield "reliability", reliability_rows(reliabilities(results))
    yield "settings", settings_rows(settings)


def _lead(results: Results) -> str:
    version = importlib.metadata.version("ido-explorer")
    return (
        "<p>The experiments of Wang et al., <i>An Improved Discriminative Optimization for 3D Rigid Point Cloud "
        "Registration</i> (2021), repeated with IDO Explorer "
        f"{version}: {len(results):,} registrations. {_scenes_sentence(results)}</p>"
        "<p><b>Every method starts from the identity:</b> the scene where it lies. All meet the same scenes; "
        "who has fewer, the first of them. <b>PointAcc</b> is the share of a scene's true points that end "
        "within 0.1 of their place, <b>PointRMSE</b> the root mean square of their distances from it "
        "(model units; the model's half-size is 1). ± is the 95% confidence interval.</p>"
    )


def _scenes_sentence(results: Results) -> str:
    """Plainly, how many scenes there are at a level of the paper's sweeps, and how much was not run."""
    results = results.among(sweep=LEVELS, method=COMPARED_METHODS)
    if not len(results):
        return "Nothing of the paper's sweeps was run yet."
    keys = np.stack([results.dataset, results.method, results.sweep, results.level.astype(str)])
    counts = np.unique(keys, axis=1, return_counts=True)[1]
    fewest, most = int(counts.min()), int(counts.max())
    if fewest == most == PAPER_SCENES:
        scenes = f"There are {most} scenes at every level that was run, as in the paper."
    elif fewest == most:
        scenes = f"<b>Scenes at every level that was run: only {most}; the paper has {PAPER_SCENES}.</b>"
    else:
        scenes = (
            f"<b>The number of scenes at a level is uneven, {fewest} to {most}; the paper has {PAPER_SCENES}.</b> "
            "See “What was run”."
        )
    expected = sum(map(len, LEVELS.values())) * sum(len(methods_of(dataset)) for dataset in SHAPES)
    if len(counts) < expected:
        scenes += f" <b>Not everything was run:</b> {len(counts)} of {expected} levels of the methods' sweeps."
    return scenes


def _results_sections(results: Results, figures: _Figures) -> Iterator[Section]:
    from ido.experiments.gallery import sweep_figures

    for dataset, shape in SHAPES.items():
        tables = [table for table in PAPER_TABLES if table.dataset == dataset]
        body = "".join(_score_html(results, table) for table in tables) + _reading_note(dataset)
        if len(results.where(dataset=dataset).among(sweep=LEVELS)):
            body += figures.html(sweep_figures(results, dataset))
        else:
            body += "<p>The sweeps of this cloud were not run.</p>"
        yield shape.title, body


def _beyond_sections(results: Results) -> Iterator[Section]:
    beyond = results.among(sweep=BEYOND)
    if not len(beyond):
        return
    tables = "".join(f"<h3>{shape.title}</h3>{beyond_table(results, name)}" for name, shape in SHAPES.items())
    yield (
        "Scenes beyond the paper's",
        "<p>Mean PointAcc on scenes that no method was made for, each turned and shifted at random: a single view that "
        "hides what lies behind, ball-shaped holes, clutter of the other shape, and density that changes over the "
        f"cloud. Bold: the best mean.</p>{tables}",
    )


def _sure_sections(results: Results, figures: _Figures) -> Iterator[Section]:
    from ido.experiments.gallery import sure_figures

    found = reliabilities(results)
    if not found:
        return
    yield (
        "How sure",
        "<p>Some methods say how probable it is that their pose is right (PointAcc of at least 0.9), without knowing "
        "the truth. ECE, the expected calibration error, is the mean distance between what was told and the share that "
        f"was right, over ten bins.</p>{reliability_table(found)}"
        '<p class="note"><small>tables/reliability.csv</small></p>' + figures.html(sure_figures(found)),
    )


def _score_html(results: Results, table: PaperTable) -> str:
    better = "higher" if table.score == "accuracy" else "lower"
    heading = f"<h3>Table {table.number}. {table.caption} <small>{better} is better</small></h3>"
    other = {"III": "I", "IV": "II"}.get(table.number, "")
    slip = _SLIP.format(other=other) if table.repeated else ""
    file = f"<p class='note'><small>tables/{table.dataset}-{table.score}.csv</small></p>"
    return heading + score_table(results, table) + slip + file


def _reading_note(dataset: str) -> str:
    urban = "The urban scan stands in for the paper's, which cannot be redistributed: the two are not comparable. "
    return (
        f'<p class="note">{urban if dataset == "urban" else ""}Blue rows are the paper\'s, which has one setting of '
        "each method; default are the authors' settings, tuned were chosen on other scenes. Bold: our best mean of the "
        "sweep; where intervals overlap, that may be chance. ± ?: fewer than two scenes at some level. "
        f"A sweep has a mean only where all its levels were run. Times and iterations are medians. {_KCCE}</p>"
    )


def _method_sections(figures: _Figures) -> Iterator[Section]:
    from ido.experiments.gallery import method_figures

    note = "<p>Drawn from the maps that ship with this version.</p>"
    yield "How DO and Improved DO learn and register", note + figures.html(method_figures())


def _run_sections(results: Results, settings: Settings) -> Iterator[Section]:
    scenes = "".join(f"<h3>{shape.title}</h3>{scenes_table(results, name)}" for name, shape in SHAPES.items())
    yield (
        "What was run",
        "<p>One perturbation varies in each sweep, the others stay at their defaults. The paper gives the ranges of "
        "the sweeps, not their levels. A scene is drawn by its seed, the same on every machine.</p>"
        + levels_table(results)
        + '<p class="note"><small>tables/levels.csv holds the numbers of every level</small></p>'
        f'<p class="before">Scenes at each level:</p>{scenes}',
    )
    costs = "".join(f"<h3>{shape.title}</h3>{costs_table(results, name)}" for name, shape in SHAPES.items())
    yield (
        "Times and endings",
        "<p>CPU times of single registrations on the machine that ran them: compare them with each other, not with "
        "other machines. Medians are over all registrations of a method, whatever sweep they belong to. One that "
        f"failed found no pose: its PointAcc is 0, it has no PointRMSE, and it is left out of the medians.</p>{costs}",
    )
    yield (
        "Settings",
        f"<p>As recorded when the methods were run. {_KCCE}</p>{settings_table(settings)}"
        '<p class="note"><small>tables/settings.csv</small></p>'
        '<p class="before">Training of the maps that ship with this version:</p>'
        f"<ul>{''.join(_training_items())}</ul>",
    )


def _training_items() -> Iterator[str]:
    for name, shape in SHAPES.items():
        for method, histogram in LEARNED.items():
            if histogram in shipped_histograms(name):
                maps = shipped_maps(name, histogram)
                its, n_model = maps.settings, len(maps.histogram.model.points)
                yield (
                    f"<li>{method}, {shape.title}: {its.samples:,} scenes, {its.maps} maps, ridge {its.ridge:g}, "
                    f"{its.outlier_kind} outliers, seed {its.seed}, {n_model} model points</li>"
                )
