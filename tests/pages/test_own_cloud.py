"""A cloud of one's own before it is trained on: what is said while one is read, and after."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from any_explorer import AT_THE_END
from unseen_explorer import OpenUnseen, UnseenExplorer

from ido import Cloud, Model, TrainingSettings, TripleBinary, train
from ido_viz.app import App
from ido_viz.own.workshop import Workshop


@pytest.fixture
def its_explorer(open_unseen: OpenUnseen, tmp_path: Path) -> Iterator[UnseenExplorer]:
    app = App(AT_THE_END, port=0, data=tmp_path)
    yield open_unseen(app=app)
    app.stop()


def file_of(cloud: Cloud, step: int) -> bytes:
    return "\n".join(" ".join(map(str, point)) for point in cloud.points[::step].tolist()).encode()


def test_while_a_file_is_read_the_draft_before_cannot_be_trained_and_a_bad_file_leaves_it(
    its_explorer: UnseenExplorer, bunny: Cloud, monkeypatch: pytest.MonkeyPatch
):
    explorer, may_read, really = its_explorer, threading.Event(), Workshop.drafted

    def waits(workshop: Workshop, name: str, content: bytes) -> Any:
        assert may_read.wait(60)
        return really(workshop, name, content)

    monkeypatch.setattr(Workshop, "drafted", waits)
    may_read.set()
    explorer.upload("Upload a cloud", "first.xyz", file_of(bunny, 20))
    explorer.wait_until("the first", lambda: "Train" in explorer.buttons() and explorer.value("Name") == "first")

    may_read.clear()
    explorer.upload("Upload a cloud", "second.xyz", file_of(bunny, 30))
    explorer.wait_until("that it is read", lambda: explorer.says("Reading second.xyz…"))
    assert "Train" not in explorer.buttons() and not explorer.says("points read")
    may_read.set()
    explorer.wait_until("the second", lambda: "Train" in explorer.buttons() and explorer.value("Name") == "second")

    explorer.upload("Upload a cloud", "third.xyz", b"no numbers")
    explorer.wait_until("what is wrong", lambda: explorer.says("This file cannot be used."))
    assert "Train" in explorer.buttons() and explorer.value("Name") == "second"


def test_the_menu_of_kept_clouds_stands_on_the_one_that_the_panes_show(
    its_explorer: UnseenExplorer, bunny: Cloud, tmp_path: Path
):
    explorer = its_explorer
    train(bunny, TripleBinary(Model.of(bunny, 64)), TrainingSettings(samples=60, maps=2)).save(tmp_path / "maps.npz")
    for name in ("first", "second"):
        explorer.upload("Import maps (.npz)", f"{name}.npz", (tmp_path / "maps.npz").read_bytes())
        explorer.wait_until("it", lambda name=name: explorer.value("Cloud") == name)
    for shape in ("first", "second", "first"):
        explorer.choose("Shape", shape)
        explorer.wait_until("the panes' cloud", lambda shape=shape: explorer.value("Cloud") == shape)
    explorer.choose("Shape", "bunny")
    explorer.wait_until("the bunny", lambda: explorer.state().shape == "bunny")
    assert explorer.value("Cloud") == "first"
