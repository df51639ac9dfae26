"""The command line of the experiments: `ido experiment run`, `report` and `tune`."""

from __future__ import annotations

from collections import Counter, defaultdict
from concurrent.futures import BrokenExecutor, Executor
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table
from tyro.conf import Positional, arg
from tyro.extras import SubcommandApp

from ido.console import note, progress_bar
from ido.experiments.beyond import ALL_LEVELS, BEYOND
from ido.experiments.execution import FAILED, MOST_SCENES, Experiment, run
from ido.experiments.families import COMPARED_METHODS
from ido.experiments.report import report_command
from ido.experiments.store import Row, Store, check_folder
from ido.experiments.sweeps import LEVELS
from ido.experiments.tune import tune_command
from ido.experiments.workers import executor_of
from ido.methods import is_installed
from ido.peers.peer import PEERS_EXTRA
from ido.results import Results
from ido.shipped import SHAPES

if TYPE_CHECKING:
    DatasetName = MethodName = SweepName = str
else:
    DatasetName, MethodName, SweepName = Literal[tuple(SHAPES)], Literal[COMPARED_METHODS], Literal[tuple(ALL_LEVELS)]

_METHODS_HELP = (
    f"Methods to compare, each in quotes: {', '.join(COMPARED_METHODS)}. Default: all whose libraries are installed."
)

app = SubcommandApp()
"""`ido experiment ...`."""

app.command(name="report")(report_command)
app.command(name="tune")(tune_command)


@app.command(name="run")
def run_command(
    what: Positional[Literal["paper", "beyond"]] = "paper",
    output: Annotated[Path, arg(aliases=["-o"], metavar="FILE.sqlite")] = Path("ido-results.sqlite"),
    datasets: tuple[DatasetName, ...] = tuple(SHAPES),
    sweeps: tuple[SweepName, ...] | None = None,
    methods: Annotated[tuple[MethodName, ...] | None, arg(metavar="METHOD ...", help=_METHODS_HELP)] = None,
    levels: tuple[float, ...] | None = None,
    scenes: int = MOST_SCENES,
    polish: bool = False,
    workers: int | None = None,
    dask: Annotated[str | None, arg(metavar="ADDRESS")] = None,
) -> int | None:
    """Register the scenes of the paper's test sweeps with every method, and keep every result.

    Each result goes to a SQLite file as soon as it is there. Stop whenever you like, with Ctrl-C or without warning:
    the same command goes on from there, and repeats nothing that is in the file. So does one with more scenes, methods
    or sweeps. --scenes 10 gives a first impression within minutes; all 100 take about 40 on two cores.

    At the end it prints the mean PointAcc (share of points within 0.1 of their true place) of every method over each
    sweep. The exit code is 130 after Ctrl-C.

    Args:
        what: The experiment: the paper's sweeps, or scenes beyond them, which no method was made for: a single view,
            holes, clutter of another shape, uneven density.
        output: Where the results go; a file already there is continued.
        datasets: Shapes to perturb.
        sweeps: Which perturbations to vary, or which scenes beyond. Default: all of the experiment.
        levels: Only these levels of the sweeps, where a sweep has them. Default: all.
        scenes: Scenes at each level, at most 100. Fewer are the first of more.
        polish: Also run each method with its last pose made better by the end of the global method (`ido.polish`).
        workers: Processes on this machine. Default: one for each core.
        dask: Work on the Dask cluster with this scheduler (tcp://HOST:PORT), whose workers have this program, too.
    """
    check_folder(output)
    its_sweeps = tuple(LEVELS if what == "paper" else BEYOND)
    if strange := set(sweeps or ()) - set(its_sweeps):
        raise ValueError(f"{', '.join(sorted(strange))}: not of this experiment; choose from {', '.join(its_sweeps)}")
    if methods is None:
        methods = tuple(name for name in COMPARED_METHODS if is_installed(name))
        if left_out := [name for name in COMPARED_METHODS if name not in methods]:
            note(f"without {', '.join(left_out)}: they need {escape(PEERS_EXTRA)}")
    experiment = Experiment(
        datasets=datasets,
        sweeps=its_sweeps if sweeps is None else sweeps,
        methods=methods,
        levels=levels,
        scenes=scenes,
        polish=polish,
    )
    try:
        with (
            executor_of(workers, dask) as (executor, in_flight),
            Store.open(output, experiment.dataset_settings(), experiment.method_settings()) as store,
        ):
            _complete(experiment, store, executor, in_flight)
            results = store.results()
    except KeyboardInterrupt:
        note(f"interrupted; {escape(_kept(output))}")
        return 130
    except BrokenExecutor as error:
        raise BrokenExecutor(f"{str(error).rstrip('.')}; {_kept(output)}") from error
    means = mean_accuracies(results, experiment)
    for dataset in experiment.datasets:
        print(f"{dataset}: mean PointAcc, {scenes} scenes a level")
        Console().print(_table(dataset, means, experiment))
    failures = Counter(str(name) for name in results.where(stop=FAILED).method)
    for name, count in failures.items():
        note(f"[bold yellow]warning:[/] {escape(name)} failed {count} times in this file; that counts as PointAcc 0")
    return None


def _complete(experiment: Experiment, store: Store, executor: Executor, in_flight: int) -> None:
    """Run what is missing."""
    chunks = experiment.missing(store.recorded())
    n_missing, n_total = sum(len(chunk.trials) for chunk in chunks), len(experiment.keys)
    with progress_bar("{task.completed:,.0f} of {task.total:,.0f} registrations") as progress:
        task = progress.add_task("", total=n_total, completed=n_total - n_missing)

        def record(rows: list[Row]) -> None:
            store.append(rows)
            progress.advance(task, len(rows))

        run(chunks, executor, in_flight, record)


def mean_accuracies(results: Results, experiment: Experiment) -> dict[tuple[str, str, str], float]:
    """Mean PointAcc of each (dataset, method, sweep), over the levels and scenes of an experiment."""
    chosen = set(experiment.keys)
    columns = (results.dataset, results.method, results.sweep, results.level, results.trial)
    groups: dict[tuple[str, str, str], list[float]] = defaultdict(list)
    for key, accuracy in zip(zip(*(c.tolist() for c in columns), strict=True), results.accuracy, strict=True):
        if key in chosen:
            groups[key[:3]].append(accuracy)
    return {group: float(np.mean(values)) for group, values in groups.items()}


def _table(dataset: str, means: dict[tuple[str, str, str], float], experiment: Experiment) -> Table:
    table = Table("", box=box.SIMPLE, padding=0)  # fits into 80 columns
    for sweep in experiment.sweeps:
        table.add_column(sweep, justify="right", no_wrap=True)
    for shape, method in experiment.pairs:
        if shape == dataset:
            values = [means.get((dataset, method, sweep)) for sweep in experiment.sweeps]
            table.add_row(escape(method), *("" if value is None else f"{value:.3f}" for value in values))
    return table


def _kept(output: Path) -> str:
    return f"what is done is kept in {output}; the same command goes on from there"
