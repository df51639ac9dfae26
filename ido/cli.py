"""The command line: `ido train`, `ido register`, `ido sweep` and `ido experiment`."""

from __future__ import annotations

import contextlib
import secrets
import sys
import tempfile
import time
import warnings
from collections.abc import Sequence
from concurrent.futures import BrokenExecutor
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import tyro
from rich.console import Console
from rich.markup import escape
from rich.table import Table
from tyro.conf import arg
from tyro.extras import SubcommandApp

from ido.arguments import MAPS_HELP, CloudName, HistogramName, habits, maps_of, place_of, points_of
from ido.clouds import Cloud, CloudWarning, Model, Orientation
from ido.console import ended_as_by_ctrl_c, note, progress_bar, replace_what_cannot_be_shown
from ido.disk import check_apart, check_output
from ido.experiments import LEVELS, mean_and_interval, sweep
from ido.experiments.commands import app as experiments
from ido.experiments.workers import executor_of
from ido.extensions import histogram_class
from ido.maps import Maps, TrainingSettings
from ido.perturbation import OutlierKind, Perturbation
from ido.registering import register_command
from ido.registration import EPSILON
from ido.training import train
from ido.user_units import cloud_of_maps

if TYPE_CHECKING:
    SweepName = str
else:
    SweepName = Literal[tuple(LEVELS)]


def main(args: Sequence[str] | None = None) -> int | None:
    """Run a command; the exit code is 2 for an error, 3 for a doubt under --strict, 130 after Ctrl-C."""
    app = SubcommandApp()
    app.command(name="train")(train_command)
    app.command(name="register")(register_command)
    app.command(name="sweep")(sweep_command)
    app.command(experiments, name="experiment", help="Compare every method with the others and with the paper.")
    description = "Register 3D point clouds with Discriminative Optimization (DO) and Improved DO."
    replace_what_cannot_be_shown()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always", CloudWarning)
            warnings.showwarning = _show_warning
            return app.cli(prog="ido", description=description, args=args, config=(tyro.conf.DisallowNone,))
    except KeyboardInterrupt:
        return _interrupted()
    except ImportError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):  # what Open3D makes of Ctrl-C while it is imported
            return _interrupted()
        raise
    except OSError as error:
        note(f"[bold red]error:[/] {escape(f'{error.filename}: {error.strerror}' if error.filename else str(error))}")
    except MemoryError as error:
        note(f"[bold red]error:[/] not enough memory; {escape(str(error))}")
    except (ValueError, BrokenExecutor) as error:
        message = " ".join(str(error).split())  # readers of foreign files write several lines
        note(f"[bold red]error:[/] {escape(message)}")
    return 2


def train_command(
    cloud: CloudName,
    output: Annotated[Path, arg(aliases=["-o"], metavar="FILE.npz")],
    histogram: HistogramName = "triple-binary",
    samples: int = TrainingSettings().samples,
    maps: int = TrainingSettings().maps,
    ridge: float = TrainingSettings().ridge,
    seed: int = TrainingSettings().seed,
    outlier_kind: OutlierKind | None = None,
    normals: Orientation | None = None,
    workers: int | None = None,
    dask: Annotated[str | None, arg(metavar="ADDRESS")] = None,
    drop_invalid: bool = False,
    force: bool = False,
) -> int | None:
    """Learn maps for a cloud (the paper's Algorithm 1), which `ido register` then walks.

    The cloud is normalised and 514 model points are spread over it. Random scenes of it, each with its own noise,
    outliers, missing part and pose, teach one map after the other how to move a scene back onto the model. The
    defaults are the paper's. They take a few minutes and about 1 GB of memory on two cores.

    Ctrl-C ends the training early and saves the maps finished by then, as does SIGTERM; the exit code is then 130. If
    the disk is full at the end, the maps go to another folder, which is printed, and the exit code is 2.

    Args:
        cloud: File or shipped shape.
        output: Where the maps go, once training has ended.
        histogram: What the maps see of a scene: front-back is DO, triple-binary is Improved DO, and
            module:Class is one of your own.
        samples: Number of training scenes. Fewer train faster and register worse.
        maps: Number of maps.
        ridge: Weight λ of the penalty on large maps.
        seed: Draws the training scenes; the same seed gives the same maps.
        outlier_kind: Spread evenly, or gathered in one ball. Default: the shape's own, else uniform.
        normals: Side the model's normals point to; changes no result. Default: the shape's own, else outward.
        workers: Describe the scenes in this many processes. Default: threads of this one, about as fast.
        dask: Describe them on the Dask cluster with this scheduler (tcp://HOST:PORT).
        drop_invalid: Leave out points with coordinates that are not finite, instead of refusing the cloud.
        force: Replace a file that is already there.
    """
    check_apart({"-o": output}, {"the cloud": place_of(cloud)})
    check_output(output, ".npz", force=force)
    kind, orientation = habits(cloud, outlier_kind, normals)
    settings = TrainingSettings(samples=samples, maps=maps, ridge=ridge, seed=seed, outlier_kind=kind)
    pool = nullcontext((None, 0)) if workers is None and dask is None else executor_of(workers, dask)
    normalised = Cloud.of(points_of(cloud, drop_invalid=drop_invalid))
    feature = histogram_class(histogram)(Model.of(normalised, orientation=orientation))
    began = time.monotonic()
    bar = progress_bar("{task.completed} of {task.total} maps", "{task.description}")
    with ended_as_by_ctrl_c(), pool as (executor, _), bar as progress:
        task = progress.add_task(f"drawing {samples:,} scenes", total=maps)

        def show(done: int, error: float) -> None:
            progress.update(task, completed=done, description=f"training error {error:.5f}")

        try:
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", ".*Theorem 1")  # told below
                trained = train(normalised, feature, settings, progress=show, executor=executor)
        except KeyboardInterrupt:
            note("interrupted before the first map was finished; nothing was written")
            return 130
    place = save_somewhere(trained, output)
    for line in training_summary(trained, time.monotonic() - began):
        note(line)
    note(f"written to {escape(str(place))}")
    if place != output:
        return 2
    return None if trained.complete else 130


def save_somewhere(maps: Maps, output: Path) -> Path:
    """Save maps, in another folder if theirs cannot be written to any more; where they are.

    Raises:
        OSError: they can be written nowhere.
    """
    try:
        maps.save(output)
        return output
    except OSError as error:
        note(f"[bold red]error:[/] {escape(f'{output}: {error.strerror}')}; the maps go elsewhere")
        for folder in (Path.cwd(), Path.home(), Path(tempfile.gettempdir())):
            place = folder / f"{output.stem}.{secrets.token_hex(4)}.npz"
            with contextlib.suppress(OSError):
                maps.save(place)
                return place
        raise


def sweep_command(
    cloud: CloudName,
    maps: Annotated[tuple[str, ...], arg(metavar="FILE.npz ...", help=f"Maps to compare: files {MAPS_HELP}")],
    histogram: HistogramName | None = None,
    scenes: int = 100,
    sweeps: tuple[SweepName, ...] = tuple(LEVELS),
    epsilon: float = EPSILON,
    seed: int = 1_000_000,
    outlier_kind: OutlierKind | None = None,
) -> None:
    """Score maps as the paper does: perturb the cloud in many ways and register every scene.

    In each sweep one perturbation takes several levels while the others keep the paper's test defaults. The table
    gives the mean PointAcc (share of points within 0.1 of their true place) with its 95% confidence interval, and the
    mean PointRMSE, over all levels and scenes. All maps get the same scenes.

    Args:
        cloud: The cloud that the maps were trained on.
        maps: Maps to compare.
        histogram: What some of them see, as module:Class, when it is a feature of your own.
        scenes: Scenes at each level, at least 2.
        sweeps: Which perturbations to vary.
        epsilon: Stop a registration once an update is shorter than this.
        seed: Draws the scenes.
        outlier_kind: Spread evenly, or gathered in one ball. Default: the shape's own, else uniform.
    """
    if scenes < 2:
        raise ValueError(f"a confidence interval needs at least 2 scenes, not {scenes}")
    if not maps or not sweeps:
        raise ValueError("name at least one of the maps and one of the sweeps")
    if not (np.isfinite(epsilon) and epsilon >= 0):
        raise ValueError(f"epsilon must be a number of at least 0, not {epsilon}")
    base = Perturbation(outlier_kind=habits(cloud, outlier_kind, None)[0], seed=seed)
    original = points_of(cloud)
    methods = {name: maps_of(name, histogram) for name in maps}
    clouds = {name: cloud_of_maps(trained, original) for name, trained in methods.items()}
    table = Table("sweep", *map(escape, methods), title=f"mean PointAcc ± 95% (PointRMSE), {scenes} scenes a level")
    with progress_bar("{task.completed} of {task.total} sweeps", "{task.description}") as progress:
        task = progress.add_task("", total=len(sweeps) * len(methods))
        for sweep_name in sweeps:
            row = [sweep_name]
            for name, trained in methods.items():
                progress.update(task, description=escape(f"{sweep_name}, {name}"))
                results = sweep(clouds[name], trained, sweep_name, base=base, scenes=scenes, seed=seed, epsilon=epsilon)
                accuracy, interval = mean_and_interval(results[..., 0])
                row.append(f"{accuracy:.3f} ± {interval:.3f} ({results[..., 1].mean():.3f})")
                progress.advance(task)
            table.add_row(*row)
    Console().print(table)


def training_summary(maps: Maps, seconds: float) -> list[str]:
    n, curves = len(maps.maps), maps.curves
    lines = [f"{n} maps trained in {seconds:.1f} s; training error {curves.mean[0]:.5f} to {curves.mean[-1]:.5f}"]
    if not maps.complete:
        lines.insert(0, f"[bold yellow]interrupted:[/] only {n} of {maps.settings.maps} maps were trained")
    if curves.always_falls:
        lines.append("Theorem 1 held: the training error fell at every map")
    else:
        risen = ", ".join(map(str, np.flatnonzero(np.diff(curves.mean) >= 0) + 1))
        lines.append(f"[bold yellow]Theorem 1 did not hold:[/] the training error did not fall at map {risen}")
    return lines


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: object = None,
    line: str | None = None,
) -> None:
    """A line about a cloud is for the user; all else is shown as Python shows it."""
    if issubclass(category, CloudWarning):
        note(f"[bold]note:[/] {escape(str(message))}")
    else:
        sys.stderr.write(warnings.formatwarning(message, category, filename, lineno, line))


def _interrupted() -> int:
    note("interrupted; nothing was written")
    return 130
