"""What may be uploaded: one file at a time for each page, of a bounded size, in the parts that viser's page makes."""

from __future__ import annotations

import msgspec

MOST_UPLOAD = 64 << 20
"""Bytes of a file."""

LARGEST_PART = 512 << 10
"""Bytes of a part of it; viser's page makes parts of this size."""


class _Message(msgspec.Struct):
    """What is looked at of a message about an upload."""

    type: str
    transfer_uuid: str
    size_bytes: int = -1  # of a start
    part_count: int = -1
    part_index: int = -1  # of a part
    content: bytes = b""


class UploadGate:
    """Lets through the uploads of one page that keep to the limits, and nothing else of its uploads."""

    def __init__(self) -> None:
        self._transfer = ""
        self._parts: set[int] = set()
        self._count = 0
        self._left = 0  # bytes

    def lets_through(self, message: bytes) -> bool:
        """Whether a message about an upload may go on to viser."""
        try:
            told = msgspec.msgpack.decode(message, type=_Message)
        except msgspec.MsgspecError:
            return False
        return self._begins(told) if told.type == "FileTransferStartUpload" else self._goes_on(told)

    def _begins(self, told: _Message) -> bool:
        parts = -(-told.size_bytes // LARGEST_PART)
        if self._count > len(self._parts) or not 0 < told.size_bytes <= MOST_UPLOAD or told.part_count != parts:
            return False
        self._transfer, self._parts, self._count, self._left = told.transfer_uuid, set(), parts, told.size_bytes
        return True

    def _goes_on(self, told: _Message) -> bool:
        expected = 0 <= told.part_index < self._count and told.part_index not in self._parts
        if told.transfer_uuid != self._transfer or not expected or not 0 < len(told.content) <= self._left:
            return False
        self._parts.add(told.part_index)
        self._left -= len(told.content)
        return True
