"""What is sent of a chart's new data."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import cast

import numpy as np
import pytest
import viser

from ido.types import DoubleArray, FloatArray
from ido_viz.panels.plot import Plot, changed

Columns = tuple[DoubleArray, ...]


def columns(seed: int, length: int = 40) -> Columns:
    """A chart's columns with gaps, two of which are the same for every seed."""
    rng = np.random.default_rng(seed)
    gaps = np.where(np.arange(length) < length // 2, np.nan, rng.normal(size=length))
    return (np.arange(length, dtype=np.float64), rng.normal(size=length), gaps, np.full(length, np.nan))


def put_together(made: Columns, sent: tuple[FloatArray, ...]) -> Columns:
    """As the script of the page does."""
    head, *parts = sent
    assert np.isnan(head[0])
    whole = [column.copy() for column in made]
    for column, start, part in zip(whole, head[1:].astype(int), parts, strict=True):
        column[start : start + len(part)] = part
    return tuple(whole)


@pytest.mark.parametrize("seed", range(4))
def test_what_is_sent_and_what_was_there_are_the_new_data(seed: int):
    made, data = columns(0), columns(seed)
    for found, expected in zip(put_together(made, changed(made, data)), data, strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_nothing_is_sent_of_what_is_the_same():
    made, data = columns(0), columns(1)
    assert [len(part) for part in changed(made, data)[1:]] == [0, 40, 20, 0]


def test_data_of_another_length_are_sent_whole():
    data = columns(1, 50)
    assert changed(columns(0), data) is data


class Chart:
    """Stands for viser's handle of a chart."""

    visible = True
    removed = False

    def remove(self) -> None:
        self.removed = True


class Gui:
    """Stands for viser's panels; notes what charts there were."""

    def __init__(self) -> None:
        self.charts: list[Chart] = []

    def add_folder(self, _: None) -> AbstractContextManager[None]:
        return nullcontext()

    def add_uplot(self, *_: object, **__: object) -> Chart:
        self.charts.append(Chart())
        return self.charts[-1]


def test_of_a_chart_with_a_new_style_the_old_one_is_hidden_and_gone_with_the_next():
    gui = Gui()
    plot = Plot(cast(viser.GuiApi, gui), 100)
    for count in range(1, 5):
        plot.restyle(columns(0), [], {}, [])
        assert [each.visible for each in gui.charts] == [False] * (count - 1) + [True]
        assert [each.removed for each in gui.charts] == [True] * (count - 2) + [False] * min(count, 2)
