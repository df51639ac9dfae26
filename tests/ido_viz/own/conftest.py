"""What the tests of one's own clouds share: a cloud that is quickly learned, badly."""

from __future__ import annotations

import numpy as np
import pytest

from ido import Cloud, Model, TrainingSettings, train
from ido.clouds import Frame
from ido_viz.own.draft import Draft
from ido_viz.own.kept import TRAINED, Kept

TINY = TrainingSettings(samples=60, maps=2, rotation=120.0, translation=0.5)


@pytest.fixture(scope="session")
def tiny_draft(bunny: Cloud) -> Draft:
    """A thousand points of the bunny, in millimetres, and 64 model points."""
    some = np.random.default_rng(0).choice(len(bunny.points), 1000, replace=False)
    cloud = Cloud(bunny.points[some], Frame(np.array([10.0, -20.0, 30.0]), 78.0))
    return Draft("tiny", cloud, Model.of(cloud, 64), read=1000, unit="mm", up="+y")


@pytest.fixture(scope="session")
def kept(tiny_draft: Draft) -> Kept:
    maps = {name: train(tiny_draft.cloud, kind(tiny_draft.model), TINY) for name, kind in TRAINED.items()}
    return Kept("tiny", "mm", "+y", tiny_draft.cloud, maps)
