"""The command `ido register`: one scan, or all scans of a folder."""

from __future__ import annotations

from concurrent.futures import BrokenExecutor, Executor
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Annotated

from rich.markup import escape
from tyro.conf import arg

from ido.arguments import MAPS_HELP, CloudName, HistogramName, maps_of, place_of
from ido.console import note, progress_bar
from ido.disk import check_apart, check_output, write_whole
from ido.experiments.workers import executor_of
from ido.files import save_cloud
from ido.files.saving import SUFFIXES
from ido.global_scans import as_text as global_text
from ido.global_scans import global_target, register_globally
from ido.registration import EPSILON, MAX_ITERATIONS
from ido.scan_folder import FromAnyStart, Row, ScanTask, Walk, missing, open_rows, register_all, scans_in
from ido.scans import ScanSettings, as_text, register_scan
from ido.user_units import Start


def register_command(
    cloud: CloudName,
    maps: Annotated[str | None, arg(metavar="FILE.npz", help=f"Maps to walk: a file {MAPS_HELP}")] = None,
    onto: Annotated[str | None, arg(name="global", metavar="MODEL")] = None,
    histogram: HistogramName | None = None,
    start: Start = "here",
    epsilon: float = EPSILON,
    max_iterations: int = MAX_ITERATIONS,
    output: Annotated[Path | None, arg(aliases=["-o"], metavar="POSE.json")] = None,
    moved: Annotated[Path | None, arg(metavar="CLOUD.ply")] = None,
    drop_invalid: bool = False,
    force: bool = False,
    strict: bool = False,
    workers: int | None = None,
    dask: Annotated[str | None, arg(metavar="ADDRESS")] = None,
) -> int | None:
    """Find the pose that moves a cloud onto the model of trained maps (the paper's Algorithm 2).

    Writes one JSON object: T_model_scene, the 4x4 matrix that maps points of the cloud onto the model, in the units
    of the cloud that the maps were trained on, which must be the cloud's units too; the number of iterations; why it
    stopped (converged, iteration limit, diverged); whether it converged; figures of quality; and warnings, which also
    go to standard error. To standard output unless -o is given.

    That it converged does not say that the pose is right. The figures: near_share, the share of the cloud's points
    within 0.1 of the model's half-size of it, and near_rmse, their distance from it; covered_share, the share of the
    model that has such points; the cloud's spread along its principal axes, and size_ratio, as multiple of the
    model's; step, to which its coordinates are rounded; and densest_share, of points that lie in one place.

    The maps see only what lies near the model and were trained to turn it back by up to 90 degrees. A cloud that lies
    elsewhere needs --start centre (the default is where it lies, as in the paper).

    With --global MODEL instead of --maps, the cloud is registered from any start, onto a cloud or the model of maps.
    The JSON then has, instead of how it stopped, how sure the pose is: a probability, found from what can be known
    without the truth; the expected error and the covariance of the pose (shift, then turn in radians, in the model's
    frame); and other poses that fit equally. Of a cloud with more than 20000 points a random 20000 are searched with,
    and all are used at the end.

    With --maps, of a cloud with more than 4000 points a random 4000 are registered, always the same ones. Meshes are
    sampled.

    If the cloud is a folder, all files in it are registered, with --maps or --global. -o is then a file of JSON lines:
    a first one with the settings, and one for each scan as soon as it is there, or with its error. Stop whenever you
    like: the same command goes on from there. The exit code is 2 when a file could not be used.

    Args:
        cloud: File, folder or shipped shape.
        maps: Maps to walk.
        onto: Register from any start onto this: a cloud, a shipped shape, or maps, of which only the model is used.
        histogram: What the maps see, as module:Class, when it is a feature of your own.
        start: Where to start: where the cloud lies, or with its bounding-box centre moved onto the model's.
        epsilon: Stop once an update is shorter than this. The paper says 0.005; smaller is slower and more exact.
        max_iterations: Stop after this many updates in any case.
        output: Where the JSON goes.
        moved: Also write the moved cloud with all its points, in order, and its other columns, to a PLY or XYZ file.
        drop_invalid: Leave out points with coordinates that are not finite, instead of refusing the cloud.
        force: Replace files that are already there.
        strict: Exit with 3 when it did not converge, is less than 95% probable, or there are warnings.
        workers: Processes that share a folder's scans out. Default: one for each core.
        dask: Work on the Dask cluster with this scheduler (tcp://HOST:PORT), whose workers see the same files.
    """
    if (maps is None) == (onto is None):
        raise ValueError("give either --maps FILE.npz, to walk maps, or --global MODEL, to register from any start")
    settings = ScanSettings(start=start, epsilon=epsilon, max_iterations=max_iterations, drop_invalid=drop_invalid)
    if onto is not None and settings != ScanSettings(drop_invalid=drop_invalid):
        raise ValueError("--start, --epsilon and --max-iterations are for --maps; --global needs none of them")
    if Path(cloud).is_dir():
        if output is None or moved is not None:
            raise ValueError(f"{cloud}: is a folder, so give -o FILE.jsonl for the poses, and no --moved")
        who = executor_of(workers, dask)
        way = Walk(maps, histogram, settings) if maps else FromAnyStart(onto or "", histogram, drop_invalid)
        return _register_folder(Path(cloud), way, output, who, force=force, strict=strict)
    if workers is not None or dask is not None:
        raise ValueError("--workers and --dask are for a folder of scans")
    check_apart(
        {"-o": output, "--moved": moved},
        {"the cloud": place_of(cloud), "the maps file" if maps else "the model": place_of(maps or onto or "")},
    )
    if output:
        check_output(output, force=force)
    if moved:
        check_output(moved, *SUFFIXES, force=force)
    whole = moved is not None
    if onto is not None:
        target = global_target(onto, histogram)
        scan = register_globally(target, cloud, drop_invalid=drop_invalid, whole=whole)
        text = global_text(scan)
    else:
        scan = register_scan(maps_of(maps or "", histogram), cloud, settings, whole=whole)
        text = as_text(scan)
    for said in scan.used.notes:
        note(f"[bold]note:[/] {escape(said)}")
    for doubt in scan.doubts:
        note(f"[bold yellow]warning:[/] {escape(doubt)}")
    if moved:
        save_cloud(moved, scan.file.moved(scan.T_model_scene))
    if output:
        write_whole(output, f"{text}\n".encode())
    else:
        print(text)
    return 3 if strict and not scan.sure else None


def _register_folder(
    folder: Path,
    way: Walk | FromAnyStart,
    output: Path,
    who: AbstractContextManager[tuple[Executor, int]],
    *,
    force: bool,
    strict: bool,
) -> int | None:
    scans = scans_in(folder)
    own = {"the maps file": place_of(way.maps)} if isinstance(way, Walk) else {"the model": place_of(way.onto)}
    check_apart({"-o": output}, {**own, **{path.name: path for path in scans}})
    check_output(output, ".jsonl", force=True)
    way.prepare()  # refused here, not by every worker
    if force:
        output.unlink(missing_ok=True)
    kept = f"what is done is kept in {output}; the same command goes on from there"
    with open_rows(output, way) as rows:
        tasks = [ScanTask(str(path), way) for path in missing(scans, rows.found)]
        with who as (executor, in_flight), progress_bar("{task.completed} of {task.total} scans") as progress:
            task = progress.add_task("", total=len(scans), completed=len(scans) - len(tasks))

            def record(row: Row) -> None:
                rows.append(row)
                progress.advance(task)

            try:
                register_all(tasks, executor, in_flight, record)
            except KeyboardInterrupt:
                note(f"interrupted; {escape(kept)}")
                return 130
            except BrokenExecutor as error:
                raise BrokenExecutor(f"{str(error).rstrip('.')}; {kept}") from error
        failed = [row for row in rows.found if "error" in row]
        unsure = [(row["file"], why) for row in rows.found if row not in failed and (why := way.doubts(row))]
    for row in failed:
        note(f"[bold red]error:[/] {escape(row['error'])}")
    for file, why in unsure:
        note(f"[bold yellow]warning:[/] {escape(file)}: {escape('; '.join(why))}")
    note(f"{len(rows.found)} scans, {len(failed)} of them not usable, {len(unsure)} doubtful: {escape(str(output))}")
    return 2 if failed else 3 if strict and unsure else None
