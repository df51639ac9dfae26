"""All figures of the report, each with its title and caption."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from matplotlib.figure import Figure

from ido.experiments.figures_learning import maps_figure, training_figure
from ido.experiments.figures_reliability import reliability_figure
from ido.experiments.figures_steps import clouds_figure, histograms_figure
from ido.experiments.figures_sweeps import settings_figure, sweeps_figure
from ido.experiments.paper import COMPARED_MAPS, SCORE_TITLES
from ido.experiments.reliability import Reliability
from ido.methods import LEARNED
from ido.perturbation import Perturbation, perturb
from ido.results import Results
from ido.shipped import SHAPES, shipped_cloud, shipped_maps


@dataclass(frozen=True, slots=True, eq=False)
class NamedFigure:
    """A figure, the name of its files, and what is said about it.

    Args:
        name: of its files, without suffix.
        title: in a few words; also tells those who cannot see it what it shows.
        caption: how to read it.
        figure: to be drawn.
    """

    name: str
    title: str
    caption: str
    figure: Figure


def sweep_figures(results: Results, dataset: str) -> Iterator[NamedFigure]:
    """Both scores over the sweeps of a dataset: all methods, then each method's two variants side by side."""
    where = SHAPES[dataset].title
    better = {"accuracy": "higher is better", "rmse": "lower is better"}
    bands = "Lines are means at each level, bands their 95% confidence intervals"
    for score, title in SCORE_TITLES.items():
        yield NamedFigure(
            f"{dataset}-{score}-sweeps",
            f"{title} over the six sweeps, {where}",
            f"{bands}; {better[score]}. Baselines with tuned settings. Dotted: nothing is done.",
            sweeps_figure(results, dataset, score),
        )
    for score, title in SCORE_TITLES.items():
        figure = settings_figure(results, dataset, score)
        if figure is not None:
            yield NamedFigure(
                f"{dataset}-{score}-settings",
                f"{title}: default beside tuned settings, {where}",
                f"{bands}; {better[score]}. Each row is one method that was run: filled markers and solid lines are "
                "tuned settings, hollow markers and dashed lines those of its authors. For Improved DO: our reading, "
                "and the paper's formula to the letter.",
                figure,
            )


def sure_figures(found: Mapping[str, Reliability]) -> Iterator[NamedFigure]:
    """How well the probabilities that methods give agree with what was right."""
    yield NamedFigure(
        "reliability",
        "Reliability diagram",
        "Above: the share of right poses against the probability told, in ten bins, with 95% intervals; on the dashed "
        "line the two agree. Below: the poses in each bin. Both clouds, the paper's sweeps and the scenes beyond.",
        reliability_figure(found),
    )


def method_figures(shape: str = "bunny") -> Iterator[NamedFigure]:
    """What the paper shows of DO and Improved DO themselves: how they learn, and how they register one scene."""
    do, improved = (shipped_maps(shape, LEARNED[name]) for name in ("DO", "Improved DO"))
    perturbation = Perturbation(outlier_kind=SHAPES[shape].outlier_kind)
    scene = perturb(shipped_cloud(shape), perturbation)
    where = SHAPES[shape].title
    one_scene = (
        f"One scene with the paper's defaults, seed {perturbation.seed}. The paper's scene took 109 to 121 (DO) and 71 "
        "(Improved DO) iterations; ours takes fewer, so earlier ones are shown, the same for both methods."
    )
    yield NamedFigure(
        f"{shape}-training",
        f"Training curves, {where}",
        f"Panels as in the paper. (a, b): the error ‖x* − x‖² over all {do.settings.samples:,} training scenes, on a "
        f"logarithmic axis. (c to f): {do.curves.residuals.shape[1]} of the scenes, one line each.",
        training_figure(do, improved),
    )
    yield NamedFigure(
        f"{shape}-maps",
        f"Learned maps {', '.join(map(str, COMPARED_MAPS[:-1]))} and {COMPARED_MAPS[-1]}, {where}",
        "What each bin of the histogram (columns) adds to translation (ρ) and rotation (φ). Blue and red are opposite "
        "signs, each map has a scale of its own. The bins of each side are in the order of the reference line.",
        maps_figure(do, improved),
    )
    yield NamedFigure(
        f"{shape}-histograms",
        f"Histograms over the iterations against the reference line, {where}",
        f"{one_scene} Each dot is a bin, in the order of the reference line (dark): what the model sees of itself.",
        histograms_figure(do, improved, scene),
    )
    yield NamedFigure(
        f"{shape}-clouds",
        f"Clouds over the iterations, {where}",
        f"{one_scene} A parallel view from the front and a little above.",
        clouds_figure(do, improved, scene, SHAPES[shape].up),
    )
