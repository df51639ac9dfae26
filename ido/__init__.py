"""Discriminative Optimization (DO) and Improved DO for rigid registration of 3D point clouds.

In the order of the paper: a cloud, a perturbation that makes a scene of it, a histogram that describes the scene at a
pose, training that turns many scenes into maps, registration that walks the maps, scores, and the methods it is
compared with, or that are your own.
"""

from ido.blocks import Block, Question, Surface
from ido.clouds import Cloud, CloudError, CloudWarning, Model
from ido.extensions import LearnedMethod, OwnError, OwnMethod, UpdateMethod, register_updates
from ido.files import load_cloud
from ido.global_registration import Confidence, GlobalModel, GlobalRegistration, GlobalResult, GlobalSettings, polish
from ido.histograms import (
    HISTOGRAMS,
    AsPrinted,
    BlockHistogram,
    FrontBack,
    Histogram,
    SceneBatch,
    TripleBinary,
)
from ido.maps import Maps, MapsError, TrainingCurves, TrainingSettings
from ido.methods import Method, method_names, shipped_method
from ido.perturbation import RANGES, Perturbation, Scene, perturb
from ido.recording import RecordedMethod, RecordedRun, RunError, load_run
from ido.registration import StopReason, Trajectory, register, register_batch
from ido.scores import Scores, score
from ido.shipped import SHAPES, shipped_cloud, shipped_maps, shipped_results
from ido.training import train

__all__ = [
    "HISTOGRAMS",
    "RANGES",
    "SHAPES",
    "AsPrinted",
    "Block",
    "BlockHistogram",
    "Cloud",
    "CloudError",
    "CloudWarning",
    "Confidence",
    "FrontBack",
    "GlobalModel",
    "GlobalRegistration",
    "GlobalResult",
    "GlobalSettings",
    "Histogram",
    "LearnedMethod",
    "Maps",
    "MapsError",
    "Method",
    "Model",
    "OwnError",
    "OwnMethod",
    "Perturbation",
    "Question",
    "RecordedMethod",
    "RecordedRun",
    "RunError",
    "Scene",
    "SceneBatch",
    "Scores",
    "StopReason",
    "Surface",
    "TrainingCurves",
    "TrainingSettings",
    "Trajectory",
    "TripleBinary",
    "UpdateMethod",
    "load_cloud",
    "load_run",
    "method_names",
    "perturb",
    "polish",
    "register",
    "register_batch",
    "register_updates",
    "score",
    "shipped_cloud",
    "shipped_maps",
    "shipped_method",
    "shipped_results",
    "train",
]
