"""Tables of the report, as HTML and as rows for CSV. A cell without results says so and is never a number."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape

import numpy as np

from ido.experiments.beyond import ALL_LEVELS, BEYOND
from ido.experiments.estimates import Costs, Estimate, level_estimates, sweep_estimate
from ido.experiments.families import COMPARED_METHODS, FAMILIES, Family
from ido.experiments.paper import ROW_NAMES, SCORE_TITLES, PaperTable
from ido.experiments.reliability import EDGES, Reliability
from ido.experiments.sweeps import LEVELS
from ido.methods import compared
from ido.perturbation import RANGES, Perturbation
from ido.registration import StopReason
from ido.results import Results
from ido.shipped import SHAPES

Row = Sequence[object]
NOT_RUN = '<td class="none">not run</td>'
_NO_NUMBER = '<td class="none">–</td>'


def methods_of(dataset: str) -> list[str]:
    """The methods that can register a dataset, in the order of the report."""
    known = compared(dataset)
    return [method for method in COMPARED_METHODS if method in known]


def score_table(results: Results, table: PaperTable) -> str:
    """One of the paper's tables as HTML: each method with the paper's row above ours, and what it took."""
    of_dataset = results.where(dataset=table.dataset)
    best = _best_means(of_dataset, table)
    head = ["Method", "", *ROW_NAMES.values(), "Time", "Iterations"]
    bodies = [_family_rows(of_dataset, family, table, best) for family in FAMILIES]
    return _table(head, bodies, "scores")


def _family_rows(of_dataset: Results, family: Family, table: PaperTable, best: Mapping[str, float]) -> list[str]:
    known = methods_of(table.dataset)
    rows = []
    if family.paper:
        cells = "".join(_paper_cell(table, sweep, family.paper) for sweep in ROW_NAMES)
        rows.append(f'<td class="variant">paper</td>{cells}{_NO_NUMBER}{_NO_NUMBER}')
    for variant, method in family.variants:
        run = of_dataset.where(method=method)
        cells = "".join(_cell(sweep_estimate(run, sweep, table.score), best[sweep]) for sweep in ROW_NAMES)
        costs = Costs.of(run)
        unknown = _NO_NUMBER if len(run) else NOT_RUN  # of those that failed everywhere
        for text in (time_text(costs.seconds), _count_text(costs.iterations)):
            cells += f"<td>{text}</td>" if text else unknown
        if method not in known:
            cells = f'<td class="none" colspan="{len(ROW_NAMES) + 2}">not run: no maps ship for this cloud</td>'
        rows.append(f'<td class="variant">{escape(variant)}</td>{cells}')
    name = f'<th class="method" scope="rowgroup" rowspan="{len(rows)}">{escape(family.title)}</th>'
    looks = ["paper" if family.paper and i == 0 else "" for i in range(len(rows))]
    rows[0] = name + rows[0]
    return [f'<tr class="{look}">{row}</tr>' for look, row in zip(looks, rows, strict=True)]


def _best_means(of_dataset: Results, table: PaperTable) -> dict[str, float]:
    """Our best mean of each sweep, as printed; NaN if there is none."""
    best = np.nanmax if table.score == "accuracy" else np.nanmin
    means = {
        sweep: [sweep_estimate(of_dataset.where(method=method), sweep, table.score).mean for method in COMPARED_METHODS]
        for sweep in ROW_NAMES
    }
    return {s: round(float(best(v)), 3) if np.isfinite(v).any() else math.nan for s, v in means.items()}


def _paper_cell(table: PaperTable, sweep: str, method: str) -> str:
    mark = '<span class="mark">†</span>' if sweep in table.repeated else ""
    return f'<td class="printed">{table.values[sweep][method]:.3f}{mark}</td>'


def _cell(found: Estimate, best: float) -> str:
    if found.status != "run":
        return f'<td class="none">{found.status}</td>'
    mean = f"{found.mean:.3f}"
    if round(found.mean, 3) == best:
        mean = f"<b>{mean}</b>"
    half = "?" if math.isnan(found.half) else f"{found.half:.3f}"
    failed = f'<span class="failed">{found.failed} failed</span>' if found.failed else ""
    return f'<td>{mean} <span class="half">± {half}</span>{failed}</td>'


def score_rows(results: Results, table: PaperTable) -> Iterator[Row]:
    """The same as rows, one for each method and sweep; unknown numbers are empty."""
    yield (
        *("dataset", "score", "method", "variant", "sweep", "paper", "mean", "half_of_95_percent_interval", "status"),
        *("fewest_scenes_at_a_level", "most_scenes_at_a_level", "failed", "median_seconds", "median_iterations"),
    )
    of_dataset = results.where(dataset=table.dataset)
    for family in FAMILIES:
        for variant, method in family.variants:
            run = of_dataset.where(method=method)
            costs = Costs.of(run)
            for sweep in ROW_NAMES:
                found = sweep_estimate(run, sweep, table.score)
                paper = table.values[sweep][family.paper] if family.paper else math.nan
                yield (
                    *(table.dataset, SCORE_TITLES[table.score], method, variant, sweep, _plain(paper)),
                    *(_plain(found.mean), _plain(found.half), found.status),
                    *(min(found.scenes), max(found.scenes), found.failed),
                    *(_plain(costs.seconds), _plain(costs.iterations)),
                )


def level_rows(results: Results) -> Iterator[Row]:
    """The numbers behind the sweeps' figures, one row for each dataset, method, sweep and level that was run."""
    yield (
        *("dataset", "method", "sweep", "level", "scenes", "first_seed", "last_seed"),
        *(f"{score}_{what}" for score in SCORE_TITLES for what in ("mean", "half_of_95_percent_interval")),
        *("failed", "median_seconds", "median_iterations"),
    )
    for dataset in SHAPES:
        of_dataset = results.where(dataset=dataset)
        for method in COMPARED_METHODS:
            run = of_dataset.where(method=method)
            for sweep, levels in ALL_LEVELS.items():
                by_score = [level_estimates(run, sweep, score) for score in SCORE_TITLES]
                for level, *found in zip(levels, *by_score, strict=True):
                    here = run.where(sweep=sweep, level=level)
                    if not len(here):
                        continue
                    costs = Costs.of(here)
                    yield (
                        *(dataset, method, sweep, level, len(here), here.seed.min(), here.seed.max()),
                        *(_plain(number) for each in found for number in (each.mean, each.half)),
                        *(found[-1].failed, _plain(costs.seconds), _plain(costs.iterations)),
                    )


def scenes_table(results: Results, dataset: str) -> str:
    """How many scenes of a dataset each method was run on, at each level of each sweep."""
    of_dataset = results.where(dataset=dataset)
    rows = []
    for method in methods_of(dataset):
        run = of_dataset.where(method=method)
        counts = [sweep_estimate(run, sweep, "accuracy") for sweep in ROW_NAMES]
        rows.append(_row(method, "".join(_scenes_cell(found) for found in counts)))
    return _table(["Method", *ROW_NAMES.values()], [rows])


def _scenes_cell(found: Estimate) -> str:
    if found.levels_run == 0:
        return NOT_RUN
    some = [count for count in found.scenes if count]
    text = f"{min(some)}" if min(some) == max(some) else f"{min(some)} to {max(some)}"
    return f"<td>{text}</td>" if found.status == "run" else f'<td>{text} <span class="half">{found.status}</span></td>'


def costs_table(results: Results, dataset: str) -> str:
    """What each method took on a dataset, and how its registrations ended."""
    of_dataset = results.where(dataset=dataset)
    reasons = [*StopReason, *sorted(set(of_dataset.stop.tolist()) - set(StopReason))]
    head = ["Method", "Registrations", "Median time", "Median iterations", *(f"Ended: {reason}" for reason in reasons)]
    rows = []
    for method in methods_of(dataset):
        run = of_dataset.where(method=method)
        if not len(run):
            rows.append(_row(method, NOT_RUN * (len(head) - 1)))
            continue
        costs = Costs.of(run)
        cells = [f"{costs.registrations:,}", time_text(costs.seconds), _count_text(costs.iterations)]
        cells += [f"{100 * float((run.stop == reason).mean()):.1f}%" for reason in reasons]
        rows.append(_row(method, "".join(f"<td>{cell}</td>" if cell else _NO_NUMBER for cell in cells)))
    return _table(head, [rows])


def levels_table(results: Results) -> str:
    """The sweeps: their levels, what the others stay at, and the seeds of the scenes that were run."""
    rows = []
    for sweep, name in ROW_NAMES.items():
        seeds = results.where(sweep=sweep).seed
        levels = ", ".join(f"{level:g}" for level in LEVELS[sweep])
        used = f"{seeds.min()} to {seeds.max()}" if len(seeds) else "not run"
        cells = (RANGES[sweep].unit, levels, f"{getattr(Perturbation(), sweep):g}", used)
        rows.append(_row(name, "".join(f'<td class="text">{escape(cell)}</td>' for cell in cells)))
    return _table(["Sweep", "Unit", "Levels", "Default in the other sweeps", "Seeds"], [rows], "text")


def beyond_table(results: Results, dataset: str) -> str:
    """The mean PointAcc of each method that was run on scenes beyond the paper's, polished ones too."""
    of_dataset = results.where(dataset=dataset)
    runs = [of_dataset.where(method=method) for method in sorted(set(of_dataset.method.tolist()))]
    runs = [run for run in runs if np.isin(run.sweep, list(BEYOND)).any()]
    found = [{kind: sweep_estimate(run, kind, "accuracy") for kind in BEYOND} for run in runs]
    means = {kind: [round(of_run[kind].mean, 3) for of_run in found] for kind in BEYOND}
    rows = [
        _row(
            str(run.method[0]),
            "".join(_cell(of_run[kind], np.nanmax([*means[kind], -1.0])) for kind in BEYOND)
            + f"<td>{time_text(Costs.of(run.among(sweep=BEYOND)).seconds) or '–'}</td>",
        )
        for run, of_run in zip(runs, found, strict=True)
    ]
    return _table(["Method", *BEYOND, "Time"], [rows], "scores")


def reliabilities(results: Results) -> dict[str, Reliability]:
    """Of each method that gave probabilities, in the order of the report."""
    found = {method: Reliability.of_results(results.where(method=method)) for method in COMPARED_METHODS}
    return {method: its for method, its in found.items() if its}


def reliability_table(found: Mapping[str, Reliability]) -> str:
    """How many poses were right, and how well the probabilities told which."""
    head = ("Method", "Poses", "Right", "ECE", "p ≥ 0.95", "of these right", "Wrong", "of these p < 0.5")
    rows = []
    for method, its in found.items():
        (sure, sure_right), (wrong, doubted) = its.sure, its.failures
        cells = (
            *(f"{its.total:,}", f"{its.share_right:.1%}", f"{its.error:.3f}"),
            *(f"{sure:,}", _share_text(sure_right, sure), f"{wrong:,}", _share_text(doubted, wrong)),
        )
        rows.append(_row(method, "".join(f"<td>{cell}</td>" for cell in cells)))
    return _table(head, [rows])


def reliability_rows(found: Mapping[str, Reliability]) -> Iterator[Row]:
    """The bins of the reliability diagram, one row for each method and bin."""
    yield ("method", "from", "to", "poses", "mean_probability", "share_right")
    for method, its in found.items():
        for low, high, *values in zip(EDGES[:-1], EDGES[1:], its.counts, its.told, its.right, strict=True):
            yield (method, round(low, 1), round(high, 1), *(_plain(float(value)) for value in values))


def _share_text(part: int, whole: int) -> str:
    return f"{part / whole:.1%}" if whole else "–"


def settings_table(settings: Mapping[tuple[str, str], Mapping[str, object]]) -> str:
    """All settings of every method, as recorded; once where all datasets have the same."""
    rows = []
    for method in COMPARED_METHODS:
        recorded = {
            dataset: settings_text(settings[dataset, method]) for dataset in SHAPES if (dataset, method) in settings
        }
        if len(set(recorded.values())) == 1:
            recorded = {" and ".join(recorded): next(iter(recorded.values()))}
        for where, text in recorded.items() or [("", "not run")]:
            rows.append(_row(method, f'<td class="text">{escape(where)}</td><td class="text">{escape(text)}</td>'))
    return _table(["Method", "Clouds", "Settings"], [rows], "text")


def settings_rows(settings: Mapping[tuple[str, str], Mapping[str, object]]) -> Iterator[Row]:
    """All settings as rows, with the fingerprint of the model and maps, if it was recorded."""
    yield ("dataset", "method", "setting", "value")
    for (dataset, method), values in settings.items():
        for name, value in values.items():
            yield (dataset, method, name, value)


def settings_text(settings: Mapping[str, object]) -> str:
    """Settings in one line, without the fingerprint."""
    return ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in settings.items() if name != "fingerprint")


def time_text(seconds: float) -> str:
    """A time to three digits, in a unit that suits it."""
    if math.isnan(seconds):
        return ""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= 0.9995 * size:
            return f"{seconds / size:#.3g}".rstrip(".") + f" {unit}"
    return f"{seconds * 1e3:.2f} ms"


def _count_text(count: float) -> str:
    return "" if math.isnan(count) else f"{count:,.0f}"


def _plain(number: float) -> object:
    return "" if math.isnan(number) else number


def _row(name: str, cells: str) -> str:
    return f'<tr><th class="method" scope="row">{escape(name)}</th>{cells}</tr>'


def _table(head: Iterable[str], bodies: Iterable[list[str]], look: str = "") -> str:
    names = "".join(f'<th scope="col">{escape(name)}</th>' for name in head)
    rows = "".join(f"<tbody>{''.join(body)}</tbody>" for body in bodies)
    return f'<div class="wide"><table class="{look}"><thead><tr>{names}</tr></thead>{rows}</table></div>'
