"""What the tests share: the shipped bunny, a small model of it, and a small training on that."""

from __future__ import annotations

import gc
import os
from typing import Any

import pytest
from xdist.scheduler import LoadFileScheduling

from ido import Cloud, FrontBack, Maps, Model, TrainingSettings, shipped_cloud, train

IN_A_BROWSER = "tests/browser/"
WAITING = ("tests/pages/", "tests/ido_viz/test_")
"""Tests that wait most of their time, for a page to be at rest."""
SMALL_MODEL = 80
SMALL_TRAINING = TrainingSettings(samples=600, maps=8)


def pytest_configure(config: pytest.Config) -> None:
    """What workers inherit, which start later: linear algebra in one thread, for more would only wait for each other.

    And modules that are compiled are kept, or all workers and the processes that tests start compile them anew.
    """
    if config.getoption("numprocesses", None):
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


class ByFile(LoadFileScheduling):
    """A file is one worker's; those in a browser are two workers' in all: starting one, and its pages, is work.

    Those that wait are one worker's, so that the others have work to do meanwhile.
    """

    def __init__(self, config: pytest.Config, log: Any) -> None:
        super().__init__(config, log)
        self._browser_of: dict[str, int] = {}

    def _split_scope(self, nodeid: str) -> str:
        file = super()._split_scope(nodeid)
        if file.startswith(IN_A_BROWSER):
            return f"browser {self._browser_of.setdefault(file, len(self._browser_of) % 2)}"
        return "waiting" if file.startswith(WAITING) else file


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> ByFile:
    return ByFile(config, log)


def pytest_collection() -> None:
    """No collector of garbage while thousands of tests are collected: it finds none, in a third of the time."""
    gc.disable()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """First those in a browser, which take longest, beside those that wait; then the others: all end at once."""

    def place(item: pytest.Item) -> int:
        file = item.path.relative_to(config.rootpath).as_posix()
        return 0 if file.startswith(IN_A_BROWSER) else 1 if file.startswith(WAITING) else 2

    items.sort(key=place)


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def bunny() -> Cloud:
    return shipped_cloud("bunny")


@pytest.fixture(scope="session")
def small_model(bunny: Cloud) -> Model:
    return Model.of(bunny, SMALL_MODEL)


@pytest.fixture(scope="session")
def full_model(bunny: Cloud) -> Model:
    return Model.of(bunny)


@pytest.fixture(scope="session")
def small_maps(bunny: Cloud, small_model: Model) -> Maps:
    return train(bunny, FrontBack(small_model), SMALL_TRAINING)
