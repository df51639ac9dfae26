"""The report: the paper's numbers, means and intervals, the page, its figures and its tables."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D

from ido import Cloud, Perturbation, perturb
from ido.bin_order import bin_order
from ido.experiments import LEVELS, Results, gallery, mean_and_interval
from ido.experiments.beyond import ALL_LEVELS, BEYOND
from ido.experiments.estimates import Costs, estimate, sweep_estimate
from ido.experiments.families import COMPARED_METHODS, FAMILIES
from ido.experiments.figures_learning import training_figure
from ido.experiments.figures_reliability import reliability_figure
from ido.experiments.figures_steps import histograms_figure
from ido.experiments.figures_sweeps import settings_figure, sweeps_figure
from ido.experiments.paper import PAPER_METHODS, PAPER_TABLES, ROW_NAMES, PaperTable
from ido.experiments.reliability import Reliability, wilson
from ido.experiments.report import report_command, write_report
from ido.experiments.report_page import figure_html, page
from ido.experiments.report_tables import (
    beyond_table,
    levels_table,
    score_table,
    settings_table,
    settings_text,
    time_text,
)
from ido.experiments.store import Row, Store
from ido.methods import BASELINES, FROM_ANY_START, LEARNED, MANY_STARTS, PEERS, compared
from ido.shipped import shipped_maps, shipped_results

SETTINGS = {("bunny", name): {"cutoff": 0.3, "fingerprint": "f00d"} for name in ("DO", "ICP, tuned", "Did nothing")}
RUN = ("DO", "ICP, tuned", "Did nothing")
DOCS = Path(__file__).parents[3] / "assets" / "docs"
RESULTS_TEXT, GLOBAL_TEXT = (DOCS.joinpath(f"{n}.md").read_text(encoding="utf-8") for n in ("results", "global"))
MISSING_LEVELS = ("ICP, tuned", "rotation", 2)
"""A method, a sweep and how many of its levels were run."""


@pytest.fixture(scope="module")
def results() -> Results:
    """Three methods on the bunny, with uneven numbers of scenes; one sweep of ICP is cut short; two failed."""
    rng = np.random.default_rng(0)
    rows = []
    for method in RUN:
        for sweep, levels in LEVELS.items():
            if (method, sweep) == MISSING_LEVELS[:2]:
                levels = levels[: MISSING_LEVELS[2]]
            for i, level in enumerate(levels):
                for trial in range(2 + i):
                    failed = method == "ICP, tuned" and sweep == "noise" and trial == i == 1
                    scores = (0.0, np.nan) if failed else (rng.random(), 0.5 + rng.random())
                    row = ("bunny", method, sweep, level, trial, 1000 + trial, *scores, 5.0, 0.1)
                    rows.append((*row, 0.25 + rng.random(), 40 + trial, "failed" if failed else "converged", np.nan))
    return results_of(rows)


def results_of(rows: Sequence[tuple[object, ...]]) -> Results:
    kinds = (str, str, str, float, np.int64, np.int64, *[float] * 5, np.int64, str, float)
    columns = zip(*rows, strict=True) if rows else [()] * len(kinds)
    return Results(*(np.array(column, dtype=kind) for column, kind in zip(columns, kinds, strict=True)))


@pytest.fixture(scope="module")
def folder(results: Results, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the command writes of them."""
    file, folder = tmp_path_factory.mktemp("results") / "results.sqlite", tmp_path_factory.mktemp("report") / "new"
    columns = (getattr(results, name).tolist() for name in Row._fields)
    with Store.open(file, {"bunny": {}}, SETTINGS) as store:
        store.append(Row(*row) for row in zip(*columns, strict=True))
    report_command(file, folder)
    return folder


def cells(html: str) -> list[list[str]]:
    """The text of a table's cells, row by row."""
    rows = re.findall(r"<tr[^>]*>(.*?)</tr>", html)
    return [[re.sub(r"<[^>]+>", "", cell) for cell in re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row)] for row in rows]


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


# the paper's numbers


def test_the_papers_tables_hold_what_it_prints():
    columns = {  # sums over what is printed, BCPD to OURS
        "I": (3.718, 1.866, 0.621, 0.001, 0.123, 4.505, 5.259),
        "II": (2.029, 3.263, 3.961, 6.772, 3.971, 1.371, 0.896),
        "III": (4.057, 2.014, 0.362, 0.000, 0.198, 4.060, 5.292),
        "IV": (1.799, 2.940, 4.068, 6.946, 3.466, 1.594, 0.841),
    }
    rows = {  # NoiseStd to Translation
        "I": (2.936, 3.021, 3.108, 2.841, 1.881, 2.306),
        "II": (3.146, 3.141, 3.129, 3.295, 5.245, 4.307),
        "III": (2.919, 2.992, 3.060, 2.802, 1.904, 2.306),
        "IV": (3.030, 2.993, 3.015, 3.160, 5.149, 4.307),
    }
    for table in PAPER_TABLES:
        sums = [sum(row[method] for row in table.values.values()) for method in PAPER_METHODS]
        assert sums == pytest.approx(columns[table.number], abs=1e-9)
        sums = [sum(table.values[sweep].values()) for sweep in ROW_NAMES]
        assert sums == pytest.approx(rows[table.number], abs=1e-9)
    assert [(t.number, t.dataset, t.score) for t in PAPER_TABLES] == [
        ("I", "bunny", "accuracy"),
        ("II", "bunny", "rmse"),
        ("III", "urban", "accuracy"),
        ("IV", "urban", "rmse"),
    ]


def document_tables(text: str = RESULTS_TEXT) -> dict[str, list[list[str]]]:
    """All tables of a document that the script writes, by name; the cells of each, the head first."""
    parts = re.findall(r"<!-- begin (\S+) -->\n(.*?)\n<!-- end", text, re.DOTALL)
    return {
        name: [[cell.strip() for cell in line[1:-1].split("|")] for line in part.splitlines() if "---" not in line]
        for name, part in parts
        if part.startswith("|")
    }


def mean_of_levels(results: Results, sweep: str, score: str) -> float:
    run = results.where(sweep=sweep)
    return float(np.mean([np.nanmean(getattr(run, score)[run.level == level]) for level in ALL_LEVELS[sweep]]))


@pytest.mark.parametrize("printed", PAPER_TABLES, ids=lambda table: f"{table.dataset}-{table.score}")
def test_the_documents_tables_are_the_shipped_results_and_the_papers_numbers(printed: PaperTable):
    (head, *rows) = document_tables()[f"{printed.dataset}-{printed.score}"]
    assert head == [printed.dataset, *LEVELS]
    results, papers_rows = shipped_results().where(dataset=printed.dataset), 0
    for method, *texts in rows:
        of_method, of_paper = results.where(method=method), re.split(r",| \(rec", method)[0]
        assert len(of_method)
        for sweep, cell in zip(LEVELS, texts, strict=True):
            mean, half, *papers = map(float, re.findall(r"[\d.]+", cell))
            assert abs(mean_of_levels(of_method, sweep, printed.score) - mean) < 0.00051
            assert abs(sweep_estimate(of_method, sweep, printed.score).half - half) < 0.00051
            assert papers == ([printed.values[sweep][of_paper]] if of_paper in PAPER_METHODS else [])
        papers_rows += of_paper in PAPER_METHODS
    assert papers_rows == len(PAPER_METHODS)
    assert {row[0] for row in rows} >= {name for name in LEARNED if len(results.where(method=name))}


def test_the_documents_summary_is_the_mean_over_the_sweeps():
    _, *rows = document_tables()["summary"]
    results, checked = shipped_results(), 0
    for title, *texts, time in rows:
        tuned = f"{title}, tuned" in BASELINES
        names = (f"{title}, default", f"{title}, tuned") if tuned else (title, "")
        for dataset, (papers, *ours) in zip(("bunny", "urban"), (texts[:3], texts[3:]), strict=True):
            printed = next(t for t in PAPER_TABLES if (t.dataset, t.score) == (dataset, "accuracy")).values
            of_paper = title.removesuffix(" (reconstruction)")
            means = [row[of_paper] for row in printed.values()] if of_paper in PAPER_METHODS else []
            assert (abs(np.mean(means) - float(papers)) < 0.00051) if means else papers == ""
            for name, text in zip(names, ours, strict=True):
                run = results.where(dataset=dataset, method=name)
                assert bool(text) == bool(len(run))
                if text:
                    assert abs(np.mean([mean_of_levels(run, s, "accuracy") for s in LEVELS]) - float(text)) < 0.00051
                    checked += 1
        if time:
            seconds = results.where(dataset="bunny", method=names[1] or names[0]).among(sweep=LEVELS).seconds
            assert abs(float(np.median(seconds)) * 1e3 - float(time.removesuffix(" ms"))) <= 0.5
    known = results.among(method=[*LEARNED, *BASELINES])
    assert checked == len(set(zip(known.dataset.tolist(), known.method.tolist(), strict=True)))


def test_the_tables_from_any_start_are_the_shipped_results():
    tables, shown = document_tables(GLOBAL_TEXT), set()
    for name, sweeps in (("global-sweeps", LEVELS), ("global-beyond", BEYOND)):
        head, *rows = tables[name]
        assert head[3:-1] == list(sweeps)
        for dataset, method, scenes, *cells, milliseconds in rows:
            run = shipped_results().where(dataset=dataset, method=method).among(sweep=sweeps)
            for sweep, cell in zip(sweeps, cells, strict=True):
                counts = [(run.where(sweep=sweep).level == level).sum() for level in ALL_LEVELS[sweep]]
                assert int(scenes.split()[0]) <= min(counts) and max(counts) <= int(scenes.split()[-1])
                if cell:
                    mean, half = map(float, cell.split(" ± "))
                    assert abs(mean_of_levels(run, sweep, "accuracy") - mean) < 0.00051
                    assert abs(sweep_estimate(run, sweep, "accuracy").half - half) < 0.00051
            assert abs(float(np.median(run.seconds)) * 1e3 - float(milliseconds.removesuffix(" ms"))) <= 0.5
            shown.add((dataset, method, name))
    results = shipped_results()
    for name, sweeps in (("global-sweeps", LEVELS), ("global-beyond", BEYOND)):
        there = results.among(sweep=sweeps)
        pairs = set(zip(there.dataset.tolist(), there.method.tolist(), strict=True))
        assert {(*pair, name) for pair in pairs if pair[1] not in {*LEARNED, *BASELINES}} <= shown
    _, *rows = tables["reliability"]
    for method, poses, right, error, sure, doubted in rows:
        run = results.where(method=method)
        p, is_right = run.probability, run.accuracy >= 0.9
        assert int(poses.replace(",", "")) == len(run) and abs(is_right.mean() - float(right)) < 0.00051
        bins = np.minimum((p * 10).astype(int), 9)
        parts = [abs(p[bins == k].mean() - is_right[bins == k].mean()) * (bins == k).mean() for k in set(bins)]
        assert abs(sum(parts) - float(error)) < 0.00051
        assert sure == f"{(is_right & (p >= 0.95)).sum()} of {(p >= 0.95).sum()}"
        assert doubted == f"{(~is_right & (p < 0.5)).sum()} of {(~is_right).sum()}"


def test_the_documents_differences_are_those_on_the_same_scenes():
    (_, _, *sweeps, _), *rows = document_tables()["pairs"]
    for dataset, pair, *texts in rows:
        runs = [shipped_results().where(dataset=dataset, method=name) for name in pair.split(" - ")]
        for sweep, text in zip(sweeps, texts[:-1], strict=True):
            means = [mean_of_levels(run, sweep, "accuracy") for run in runs]
            assert abs(means[0] - means[1] - float(text.split(" ")[0])) < 0.00051
        assert abs(np.mean([float(text.split(" ")[0]) for text in texts[:-1]]) - float(texts[-1].split(" ")[0])) < 0.001
    near = next(row for row in rows if row[1] == "Improved DO (near / far) - Improved DO")
    means, halves = zip(*(map(float, text.split(" ± ")) for text in near[2:]), strict=True)
    assert all(abs(mean) < half for mean, half in zip(means, halves, strict=True)), "the text says they are equal"
    told = re.findall(r"[+-]\d\.\d{3} ± \d\.\d{3}", RESULTS_TEXT[RESULTS_TEXT.index("## What this says") :])
    assert told and set(told) <= {text for row in rows for text in row}
    for method, error in (("triple-binary", "0.0036"), ("front-back", "0.0077"), ("quadruple-binary", "0.0014")):
        assert f"{shipped_maps('bunny', method).curves.mean[-1]:.4f}" == error and error in RESULTS_TEXT
    curves = [shipped_maps("bunny", name).curves.mean for name in ("front-back", "triple-binary", "quadruple-binary")]
    assert all((better[1:] < worse[1:]).all() for worse, better in pairwise(curves)), "the text says so"


def test_exactly_the_repeated_rows_are_marked():
    for table in PAPER_TABLES:
        other = next(t for t in PAPER_TABLES if t.score == table.score and t.dataset == "bunny")
        same = tuple(s for s in ROW_NAMES if table is not other and table.values[s] == other.values[s])
        assert table.repeated == same


# means and intervals


def test_even_counts_give_the_same_as_the_sweeps_own_summary():
    values = np.random.default_rng(1).random((5, 20))
    found = estimate(list(values))
    assert (found.mean, found.half) == pytest.approx(mean_and_interval(values))


def test_every_level_counts_the_same_however_many_scenes_it_has():
    found = estimate([np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0]), np.array([0.0, 0.5])])
    assert found.mean == pytest.approx((1.0 + 0.25) / 2)
    assert found.half == pytest.approx(1.96 * np.sqrt(0.125 / 2 / 4))  # only the second level varies


def test_the_interval_of_uneven_counts_covers_the_truth_19_times_out_of_20():
    rng = np.random.default_rng(2)
    counts, truth = (15, 40, 90), np.array([0.2, 0.5, 0.9])
    covered = 0
    for _ in range(600):
        found = estimate([rng.normal(t, 0.3, n) for t, n in zip(truth, counts, strict=True)])
        covered += abs(found.mean - truth.mean()) <= found.half
    assert covered / 600 == pytest.approx(0.95, abs=0.03)


@pytest.mark.parametrize(
    ("levels", "status"),
    [
        ([[], []], "not run"),
        ([[0.0], []], "1 of 2 levels run"),
        ([[0.5], [np.nan]], "failed"),
        ([[0.0], [0.0]], "run"),
    ],
)
def test_a_mean_needs_every_level(levels: list[list[float]], status: str):
    found = estimate([np.array(values, dtype=float) for values in levels])
    assert found.status == status
    assert np.isnan(found.mean) == (status != "run")
    assert np.isnan(found.half)


def test_failures_are_left_out_of_the_error_and_of_the_costs_but_not_of_the_accuracy(results: Results):
    icp = results.where(method="ICP, tuned", sweep="noise", level=0.02)
    assert len(icp) == 3
    assert estimate([icp.accuracy]).mean == pytest.approx(icp.accuracy.sum() / 3)
    assert estimate([icp.rmse]).mean == pytest.approx(np.nansum(icp.rmse) / 2)
    assert estimate([icp.rmse]).failed == 1
    assert Costs.of(icp).iterations == 41  # of 40, (41) and 42


# the page


class References(HTMLParser):
    """Collects what a page would load or link to, and the pictures' descriptions."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.found: list[str] = []
        self.described: list[bool] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.found += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "data", "action")]
        if tag == "img":
            self.described.append(bool(dict(attrs).get("alt")))


def test_the_page_needs_nothing_else(folder: Path):
    html = (folder / "report.html").read_text(encoding="utf-8")
    references = References(html)
    assert all(each.startswith(("data:image/svg+xml;base64,", "#")) for each in references.found)
    assert not {"script", "link", "iframe", "object"} & set(references.tags)
    style = html[html.index("<style>") : html.index("</style>")]
    assert "url(" not in style and "@import" not in style
    assert references.described.count(True) == len(list((folder / "figures").glob("*.svg"))) == 8


def test_each_picture_is_there_as_png_and_svg_and_names_no_machine(folder: Path):
    pictures = {path.stem for path in (folder / "figures").glob("*.png")}
    assert pictures == {path.stem for path in (folder / "figures").glob("*.svg")}
    assert {"bunny-training", "bunny-maps", "bunny-histograms", "bunny-clouds", "bunny-rmse-sweeps"} <= pictures
    for path in folder.rglob("*.svg"):
        text = path.read_text(encoding="utf-8")
        assert "<text" not in text, "text is outlines"
        assert not re.search(r"<dc:date>|/home/|/tmp/|/root/", text)


def test_text_cannot_become_markup():
    nasty = "<script>alert(1)</script>&\"'"
    html = page(nasty, "", [(nasty, figure_html(1, nasty, nasty, nasty, b""))])
    html += settings_table({("bunny", "DO"): {nasty: nasty}})
    assert "<script" not in html
    assert "&lt;script&gt;alert(1)&lt;/script&gt;&amp;" in html


def test_the_papers_number_stands_above_ours(results: Results):
    rows = cells(score_table(results, PAPER_TABLES[0]))
    icp = [row[0] for row in rows].index("ICP")
    assert rows[icp][1:8] == ["paper", "0.000", "0.000", "0.000", "0.000", "0.001", "0.000"]
    ours = sweep_estimate(results.where(method="ICP, tuned"), "outliers", "accuracy")
    assert rows[icp + 1][2].startswith(f"{ours.mean:.3f} ± {ours.half:.3f}")
    assert rows[icp + 2] == ["default", *["not run"] * 8]


def test_what_was_not_run_says_so_and_is_never_a_number(folder: Path, results: Results):
    for table in PAPER_TABLES:
        ours = [row for row in cells(score_table(results, table)) if "paper" not in row]
        rows = dict(zip(COMPARED_METHODS, ours[1:], strict=True))
        for method, row in rows.items():
            scores = row[-8:] if len(row) > 8 else row[1:]
            if table.dataset == "bunny" and method in RUN:
                assert "not run" not in scores
            else:
                assert all(cell.startswith("not run") for cell in scores)
    icp = next(row for row in cells(score_table(results, PAPER_TABLES[0])) if row[0] == "tuned" and "levels" in row[5])
    assert icp[5] == "2 of 7 levels run"
    html = (folder / "report.html").read_text(encoding="utf-8")
    assert "The sweeps of this cloud were not run." in html
    assert "The number of scenes at a level is uneven, 2 to 8; the paper has 100." in html
    n_levels = sum(len(levels) for levels in LEVELS.values())
    n_methods = sum(len(compared(shape)) for shape in ("bunny", "urban"))
    assert f"Not everything was run:</b> {3 * n_levels - 5} of {n_levels * n_methods} levels" in html


def test_the_page_tells_what_a_reader_must_know(folder: Path):
    html = (folder / "report.html").read_text(encoding="utf-8")
    assert len(re.findall("The paper's slip", html)) == 2
    assert "Every method starts from the identity" in html
    assert "cutoff 0.3" in html
    assert "f00d" not in html, "a fingerprint is for files"
    text = re.sub(r"<[^>]+>", "\n", html[html.index("</style>") :])
    assert "KCCE (reconstruction)" in text
    assert not re.findall(r"(?<!paper's )KCCE(?! \(reconstruction\))", text)


def test_levels_and_seeds_are_those_that_were_run(results: Results):
    rows = {row[0]: row for row in cells(levels_table(results))}
    assert rows["PointNum"][1:] == ["points before removal", "100, 400, 1000, 2500, 4000", "400", "1000 to 1005"]


def test_settings_are_told_once_where_the_clouds_agree():
    same, other = {"cutoff": 0.3, "max_iterations": 9, "fingerprint": "a"}, {"cutoff": 0.4}
    assert settings_text(same) == "cutoff 0.3, max iterations 9"
    rows = cells(settings_table({("bunny", "DO"): same, ("urban", "DO"): {**same, "fingerprint": "b"}}))
    assert ["DO", "bunny and urban", "cutoff 0.3, max iterations 9"] in rows
    rows = cells(settings_table({("bunny", "DO"): same, ("urban", "DO"): other}))
    assert ["DO", "urban", "cutoff 0.4"] in rows
    assert ["CPD, tuned", "", "not run"] in rows


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.00004, "0.04 ms"), (0.0058, "5.80 ms"), (0.1234, "123 ms"), (0.99996, "1.00 s"), (12.34, "12.3 s")],
)
def test_times_read_well(seconds: float, text: str):
    assert time_text(seconds) == text


# the tables as files


def test_tables_come_back_from_csv_as_the_numbers_they_are(folder: Path, results: Results):
    for table in PAPER_TABLES:
        rows = read_csv(folder / "tables" / f"{table.dataset}-{table.score}.csv")
        assert len(rows) == len(COMPARED_METHODS) * len(ROW_NAMES)
        for row in rows:
            found = sweep_estimate(
                results.where(dataset=table.dataset, method=row["method"]), row["sweep"], table.score
            )
            assert row["status"] == found.status
            assert float(row["mean"] or "nan") == pytest.approx(found.mean, nan_ok=True, abs=0)
            assert float(row["half_of_95_percent_interval"] or "nan") == pytest.approx(found.half, nan_ok=True, abs=0)
            family = next(f for f in FAMILIES if row["method"] in dict(f.variants).values())
            printed = table.values[row["sweep"]][family.paper] if family.paper else None
            assert row["paper"] == ("" if printed is None else str(printed))


def test_the_levels_file_has_every_level_that_was_run_and_no_other(folder: Path, results: Results):
    rows = read_csv(folder / "tables" / "levels.csv")
    assert sum(int(row["scenes"]) for row in rows) == len(results)
    for row in rows:
        here = results.where(method=row["method"], sweep=row["sweep"], level=float(row["level"]))
        assert float(row["accuracy_mean"]) == pytest.approx(here.accuracy.mean())
        assert float(row["median_seconds"]) == pytest.approx(float(np.median(here.seconds[np.isfinite(here.rmse)])))


def test_the_report_tells_how_sure_methods_were_and_what_they_do_beyond(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(gallery, "method_figures", lambda: iter(()))  # slow, and not asked here
    results = shipped_results().among(method=["Global", "DO"], sweep=BEYOND)
    html = write_report(results, tmp_path, {}).read_text(encoding="utf-8")
    assert "How sure" in html and "Scenes beyond the paper" in html
    assert html.count("The sweeps of this cloud were not run.") == 2
    assert (tmp_path / "figures" / "reliability.png").is_file()
    rows = [row for row in read_csv(tmp_path / "tables" / "reliability.csv") if int(float(row["poses"]))]
    run = results.where(method="Global")
    assert {row["method"] for row in rows} == {"Global"}
    assert sum(int(float(row["poses"])) for row in rows) == len(run)
    last = run.accuracy[run.probability >= 0.9] >= 0.9
    assert float(rows[-1]["share_right"]) == pytest.approx(last.mean())
    mean = sweep_estimate(run.where(dataset="urban"), "view", "accuracy").mean
    assert f"{mean:.3f}" in re.sub(r"<[^>]+>", " ", beyond_table(results, "urban"))


def test_probabilities_that_are_frequencies_have_no_calibration_error_and_overconfidence_has():
    rng = np.random.default_rng(3)
    p = rng.random(200_000)
    is_right = rng.random(len(p)) < p
    honest, bold = Reliability.of(p, is_right), Reliability.of(np.clip(p + 0.2, 0, 1), is_right)
    assert honest.error < 0.01 and bold.error == pytest.approx(0.18, abs=0.01)
    assert honest.counts.sum() == honest.total == len(p) and honest.share_right == pytest.approx(is_right.mean())
    assert honest.sure == ((p >= 0.95).sum(), is_right[p >= 0.95].sum())
    assert honest.failures == ((~is_right).sum(), (p[~is_right] < 0.5).sum())
    figure = reliability_figure({"Global": honest, "DO, many starts": bold})
    dots = next(line for line in figure.axes[0].lines if line.get_marker() == "o")
    np.testing.assert_allclose(np.asarray(dots.get_ydata(), dtype=float), honest.right)
    assert Reliability.of(np.array([0.0, 1.0]), np.array([False, True])).counts.tolist() == [1, *[0] * 8, 1]


def test_the_interval_of_a_share_covers_it_19_times_out_of_20():
    rng = np.random.default_rng(4)
    for share, count in ((0.5, 20), (0.9, 40), (0.98, 60)):
        low, high = wilson(rng.binomial(count, share, 4000) / count, np.full(4000, count))
        assert ((low <= share) & (share <= high)).mean() == pytest.approx(0.95, abs=0.035)


# methods and figures


def test_every_method_belongs_to_one_family_and_all_families_look_different():
    assert sorted(COMPARED_METHODS) == sorted([*LEARNED, *BASELINES, *FROM_ANY_START, *MANY_STARTS, *PEERS])
    assert len({family.color for family in FAMILIES}) == len({family.marker for family in FAMILIES}) == len(FAMILIES)


def test_a_sweep_is_drawn_at_its_means_and_only_where_it_was_run(results: Results):
    figure = sweeps_figure(results, "bunny", "accuracy")
    panel = figure.axes[list(ROW_NAMES).index("rotation")]
    assert len(panel.lines) == len(RUN)
    icp = next(line for line in panel.lines if line.get_color() == "#E69F00")
    drawn = np.asarray(icp.get_ydata(), dtype=float)
    expected = results.where(method="ICP, tuned", sweep="rotation", level=30.0).accuracy.mean()
    assert drawn[1] == pytest.approx(expected)
    assert np.isnan(drawn[2:]).all()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "ICP, tuned" in labels and "CPD, tuned: not run" in labels


def test_settings_are_drawn_of_methods_that_were_run(results: Results):
    figure = settings_figure(results, "bunny", "rmse")
    assert figure is not None
    rows = [ax.get_ylabel().splitlines()[0] for ax in figure.axes if ax.get_ylabel()]
    assert rows == ["DO", "ICP"]
    assert settings_figure(results.where(method="Did nothing"), "bunny", "rmse") is None
    assert settings_figure(results, "urban", "rmse") is None


def test_training_curves_show_the_files_errors():
    do, improved = (shipped_maps("bunny", name) for name in ("front-back", "triple-binary"))
    figure = training_figure(do, improved)
    assert [ax.get_title(loc="left")[:3] for ax in figure.axes] == ["(a)", "(b)", "(c)", "(d)", "(e)", "(f)"]
    np.testing.assert_allclose(_mean_line(figure.axes[0].lines), improved.curves.mean)
    np.testing.assert_allclose(_mean_line(figure.axes[1].lines), do.curves.mean)
    assert len(figure.axes[3].lines) == do.curves.residuals.shape[1] + 3


def test_every_block_s_bins_are_drawn_in_its_colour_however_many_there_are(bunny: Cloud):
    do, four = shipped_maps("bunny", "front-back"), shipped_maps("bunny", "quadruple-binary")
    figure = histograms_figure(do, four, perturb(bunny, Perturbation(points=100, outliers=0)))
    for maps, ax in ((do, figure.axes[0]), (four, figure.axes[1])):
        drawn = [to_rgb(line.get_color()) for line in ax.lines if line.get_marker() == "."]
        assert drawn == [tuple(value / 255 for value in block.color or ()) for block in maps.histogram.blocks]
        dots = np.concatenate([line.get_xdata() for line in ax.lines if line.get_marker() == "."])
        np.testing.assert_array_equal(dots, np.arange(maps.histogram.reference.size))


def _mean_line(lines: Sequence[Line2D]) -> np.ndarray:
    return np.asarray(next(line for line in lines if line.get_label() == "mean").get_ydata())


def test_bins_are_drawn_along_a_rising_reference_line_side_by_side():
    histogram = shipped_maps("bunny", "front-back").histogram
    order = bin_order(histogram, "reference value")
    sides = histogram.reference[order].reshape(2, -1)
    assert (np.diff(sides, axis=1) >= 0).all()
    assert sorted(order[: len(order) // 2]) == list(range(len(order) // 2))
