"""The paper's experiments: its test sweeps, every method on every scene, and the report of what came out."""

from ido.experiments.sweeps import LEVELS, level_scene, mean_and_interval, sweep, sweep_scenes
from ido.results import Results

__all__ = ["LEVELS", "Results", "level_scene", "mean_and_interval", "sweep", "sweep_scenes"]
