"""The fields of a shape are made once, in the background, for all who ask."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import numpy as np
import pytest
from tab import PATIENCE

from ido import Cloud, Perturbation, shipped_cloud
from ido.files import save_cloud
from ido.global_registration import GlobalModel
from ido_viz.core.from_any_start import GLOBAL, method_from_any_start
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.core.state import State
from ido_viz.core.verdict import Verdict

MODEL = shipped_library().subject("bunny").first_histogram.model


class Making:
    """Makes few fields quickly, but not before it is let go; counts how often."""

    def __init__(self) -> None:
        self.count = 0
        self.go = threading.Event()
        self._made = GlobalModel.of

    def __call__(self, points: np.ndarray) -> GlobalModel:
        self.count += 1
        assert self.go.wait(PATIENCE)
        return self._made(points, rotations=8)


@pytest.fixture
def making(monkeypatch: pytest.MonkeyPatch) -> Making:
    making = Making()
    monkeypatch.setattr(GlobalModel, "of", making)
    return making


def bunny() -> Cloud:
    return shipped_cloud("bunny")


def test_two_pages_wait_for_the_same_fields_and_are_told_so(making: Making):
    told: list[object] = []
    asked, models = threading.Barrier(3), []

    def ask() -> None:
        asked.wait()
        method = method_from_any_start(GLOBAL, bunny, {}, MODEL, told.append)
        assert method.registration is not None
        models.append(method.registration.model)

    pages = [threading.Thread(target=ask) for _ in range(2)]
    for page in pages:
        page.start()
    asked.wait()
    deadline = time.monotonic() + PATIENCE
    while "preparing the shape, once" not in told:
        assert time.monotonic() < deadline, told
        time.sleep(0.01)
    making.go.set()
    for page in pages:
        page.join(PATIENCE)
    assert making.count == 1
    assert models[0] is models[1]


def test_a_cloud_of_ones_own_is_registered_from_any_start(tmp_path: Path):
    file = tmp_path / "mine.ply"
    save_cloud(file, shipped_cloud("bunny").points)
    library, name = shipped_library().with_own(file, [])
    assert "Global" in library.methods(name)
    assert not [method for method in library.methods(name) if "many starts" in method]
    state = State(shape=name, left="Global", right="Did nothing", perturbation=Perturbation(rotation=170.0, seed=3))
    run = compute(state, library)
    assert run.sides[0].verdict(run.iterations) is Verdict.IN_PLACE
