"""The shapes of a server: they come back after a restart, change for those who look, and stay in their folder."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ido_viz import command
from ido_viz.command import Options
from ido_viz.core.library import Library, shipped_library
from ido_viz.core.state import State, StateError, decode, encode
from ido_viz.own import shelf as shelf_module
from ido_viz.own.card import Card
from ido_viz.own.kept import KeptCloud
from ido_viz.own.shelf import LEARNING, Shelf, ShelfError

GIVEN = shipped_library().subjects


def test_a_kept_cloud_is_offered_after_a_restart(kept: KeptCloud, tmp_path: Path):
    Shelf(GIVEN, tmp_path).keep(kept)
    again = Shelf(GIVEN, tmp_path)
    assert tuple(again) == (*GIVEN, "tiny") and again.kept == ("tiny",)
    assert again.place("tiny").unit == "mm"
    np.testing.assert_array_equal(again["tiny"].cloud().points, kept.cloud.points)
    for method, maps in kept.maps.items():
        np.testing.assert_array_equal(again["tiny"].maps[method]().maps, maps.maps)


@pytest.mark.parametrize("name", ["../up", "/abs", "a/b", "CON", "<b>bold</b>", "x.npz", "bunny", "ö – 雪"])
def test_a_name_never_becomes_a_path(kept: KeptCloud, tmp_path: Path, name: str):
    folder = tmp_path / "data"
    shelf = Shelf(GIVEN, folder)
    name = shelf.free_name(name)
    shelf.keep(replace(kept, name=name))
    (file,) = tmp_path.rglob("*.npz")
    assert file.parent == folder and set(file.stem) <= set("0123456789abcdef")
    assert list(tmp_path.iterdir()) == [folder]
    assert Shelf(GIVEN, folder).kept == (name,)


def test_two_of_a_name_are_told_apart_and_none_takes_a_shipped_name(kept: KeptCloud, tmp_path: Path):
    shelf = Shelf(GIVEN, tmp_path)
    for _ in range(2):
        shelf.keep(replace(kept, name=shelf.free_name("bunny")))
    assert shelf.kept == ("bunny (2)", "bunny (3)")
    with pytest.raises(ShelfError, match="another name"):
        shelf.keep(replace(kept, name="bunny"))


def test_a_library_sees_each_change_and_a_shape_that_was_taken_hold_of_stays_itself(kept: KeptCloud, tmp_path: Path):
    shelf = Shelf(GIVEN, tmp_path)
    library, told = Library(shelf), []
    shelf.watch(lambda: told.append(tuple(library.subjects)))
    shelf.show(kept)
    first = library.subject("tiny")
    shelf.show(kept)
    assert library.subject("tiny") is not first and first.methods == library.subject("tiny").methods
    shelf.withdraw("tiny")
    assert told == [(*GIVEN, "tiny"), (*GIVEN, "tiny"), tuple(GIVEN)]
    with pytest.raises(StateError, match="there is no shape 'tiny' on this server"):
        library.checked(decode(encode(State(shape="tiny"))))


def test_deleting_leaves_nothing_behind_and_shipped_shapes_stay(kept: KeptCloud, tmp_path: Path):
    shelf = Shelf(GIVEN, tmp_path)
    shelf.keep(kept)
    Card({}).save(shelf.place("tiny").card)
    shelf.withdraw("tiny")
    shelf.withdraw("bunny")
    assert list(tmp_path.iterdir()) == []
    assert tuple(shelf) == tuple(GIVEN)
    with pytest.raises(ShelfError, match="any more"):
        shelf.place("tiny")


def test_what_cannot_be_read_is_named_and_harms_nothing(kept: KeptCloud, tmp_path: Path):
    Shelf(GIVEN, tmp_path).keep(kept)
    (tmp_path / "damaged.npz").write_bytes(b"PK\x03\x04 nothing")
    np.savez(tmp_path / "foreign.npz", x=np.zeros(3))
    shelf = Shelf(GIVEN, tmp_path)
    assert shelf.kept == ("tiny",)
    assert [text.split(":")[0] for text in shelf.unreadable] == ["damaged.npz", "foreign.npz"]


def test_there_is_room_for_so_many(kept: KeptCloud, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    shelf = Shelf(GIVEN, tmp_path)
    monkeypatch.setattr(shelf_module, "MOST_CLOUDS", 1)
    shelf.keep(kept)
    with pytest.raises(ShelfError, match="delete one first"):
        shelf.keep(replace(kept, name="other"))
    monkeypatch.setattr(shelf_module, "MOST_CLOUDS", 2)
    monkeypatch.setattr(shelf_module, "MOST_ON_DISK", 10)
    with pytest.raises(ShelfError, match="delete one first"):
        shelf.check_room()
    assert shelf.kept == ("tiny",)


def test_what_a_killed_server_left_is_cleared_and_what_a_running_one_writes_is_not(tmp_path: Path):
    old, new = tmp_path / f"old{LEARNING}", tmp_path / f"new{LEARNING}"
    upload = tmp_path / "upload-1"
    upload.mkdir()
    for path in (old, new, upload / "file.ply"):
        path.write_bytes(b"x")
    long_ago = time.time() - 1e6
    for path in (old, upload):
        os.utime(path, (long_ago, long_ago))
    Shelf(GIVEN, tmp_path)
    assert list(tmp_path.iterdir()) == [new]


def test_where_the_system_s_folder_cannot_be_made_there_are_no_own_clouds_and_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setattr(command, "user_data_path", lambda *_, **__: tmp_path / "file" / "ido-explorer")
    assert command.data_folder(Options()) is None
    assert "name a folder with --data" in capsys.readouterr().err
    with pytest.raises(OSError):
        command.data_folder(Options(data=tmp_path / "file" / "mine"))
    assert command.data_folder(Options(data=tmp_path / "mine")) == tmp_path / "mine"


def test_what_other_servers_keep_and_delete_in_the_folder_is_found(kept: KeptCloud, tmp_path: Path):
    ours, theirs = Shelf(GIVEN, tmp_path), Shelf(GIVEN, tmp_path)
    told: list[tuple[str, ...]] = []
    ours.watch(lambda: told.append(ours.kept))
    ours.look_again()
    theirs.keep(kept)
    assert ours.kept == ()
    ours.look_again()
    ours.look_again()
    assert ours.kept == ("tiny",) and ours.place("tiny") == theirs.place("tiny")
    np.testing.assert_array_equal(ours["tiny"].cloud().points, kept.cloud.points)
    theirs.withdraw("tiny")
    ours.look_again()
    assert ours.kept == () and tuple(ours) == tuple(GIVEN)
    assert told == [("tiny",), ()]


def test_clouds_of_one_name_on_two_servers_are_both_offered(kept: KeptCloud, tmp_path: Path):
    ours, theirs = Shelf(GIVEN, tmp_path), Shelf(GIVEN, tmp_path)
    for shelf in (ours, theirs):
        shelf.keep(kept)
    ours.look_again()
    assert ours.kept == ("tiny", "tiny (2)")


def test_a_file_that_cannot_be_read_is_noted_once_and_one_that_is_being_written_is_not_looked_at(
    kept: KeptCloud, tmp_path: Path
):
    shelf = Shelf(GIVEN, tmp_path)
    (tmp_path / "damaged.npz").write_bytes(b"nothing")
    (tmp_path / ".half.npz").write_bytes(b"no")
    for _ in range(2):
        shelf.look_again()
        assert len(shelf.unreadable) == 1 and shelf.unreadable[0].startswith("damaged.npz: ")
    (tmp_path / "damaged.npz").unlink()
    shelf.look_again()
    assert shelf.unreadable == ()
