"""Uploads: whole ones of a bounded size go through, one at a time, and nothing else."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from ido_viz.serving.traffic import LARGEST, is_upload, is_used
from ido_viz.serving.uploads import LARGEST_PART, MOST_UPLOAD, UploadGate


def start(size: int, parts: int | None = None, transfer: str = "a") -> bytes:
    count = -(-size // LARGEST_PART) if parts is None else parts
    return packed(type="FileTransferStartUpload", transfer_uuid=transfer, size_bytes=size, part_count=count)


def part(index: int, size: int, transfer: str = "a") -> bytes:
    return packed(type="FileTransferPart", transfer_uuid=transfer, part_index=index, content=b"x" * size)


def packed(**message: Any) -> bytes:
    return msgspec.msgpack.encode(message)


def test_a_whole_upload_goes_through_and_another_after_it():
    gate = UploadGate()
    for transfer in ("a", "b"):
        assert gate.lets_through(start(LARGEST_PART + 10, transfer=transfer))
        assert gate.lets_through(part(0, LARGEST_PART, transfer)) and gate.lets_through(part(1, 10, transfer))


@pytest.mark.parametrize(
    "message", [start(0), start(-5), start(MOST_UPLOAD + 1), start(10, 2), start(LARGEST_PART * 3, 1), start(10, 10**9)]
)
def test_what_is_too_large_or_does_not_add_up_never_begins(message: bytes):
    gate = UploadGate()
    assert not gate.lets_through(message)
    assert not gate.lets_through(part(0, 10))


def test_the_largest_upload_may_begin():
    assert UploadGate().lets_through(start(MOST_UPLOAD))


@pytest.mark.parametrize(
    "message", [part(0, 21), part(1, 5), part(-1, 5), part(0, 0), part(0, 5, "other"), b"", b"\xc1"]
)
def test_a_part_that_was_not_announced_is_dropped(message: bytes):
    gate = UploadGate()
    assert gate.lets_through(start(20))
    assert not gate.lets_through(message)
    assert gate.lets_through(part(0, 20))
    assert not gate.lets_through(part(0, 20))


def test_a_second_upload_waits_for_the_end_of_the_first():
    gate = UploadGate()
    assert gate.lets_through(start(20))
    assert not gate.lets_through(start(20, transfer="b"))
    assert gate.lets_through(part(0, 20)) and gate.lets_through(start(20, transfer="b"))


def test_only_parts_of_uploads_may_be_as_large_as_a_message():
    assert is_upload(part(0, LARGEST_PART)) and len(part(0, LARGEST_PART)) < LARGEST
    large = packed(type="GuiUpdateMessage", updates={"value": "x" * LARGEST_PART})
    assert not is_used(large) and not is_upload(large)
    assert is_used(packed(type="GuiUpdateMessage", updates={"value": "x"}))
