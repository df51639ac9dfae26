"""Files on disk: inputs that are there, outputs that destroy nothing and are written whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path


def why_unreadable(path: Path) -> str | None:
    """Why a path is no file that can be read; None when it is one."""
    if path.is_dir():
        return "is a folder; name a file in it"
    if path.is_file():
        return None if os.access(path, os.R_OK) else "no permission to read it"
    return "is a pipe or a device; save it to a file first" if path.exists() else "no such file"


def check_output(path: Path, *suffixes: str, force: bool = False) -> None:
    """See that a file can be written, before the work begins.

    Args:
        path: the file.
        suffixes: endings that its name may have; any unless given.
        force: whether a file that is already there may be replaced.

    Raises:
        ValueError: its name has another ending, its folder cannot be written to, or it is there already.
    """
    if suffixes and path.suffix.lower() not in suffixes:
        raise ValueError(f"{path}: the name must end in {' or '.join(suffixes)}")
    if not path.parent.is_dir():
        raise ValueError(f"{path.parent}: no such folder")
    if path.is_dir():
        raise ValueError(f"{path}: is a folder")
    if path.exists() and not path.is_file():
        raise ValueError(f"{path}: is a pipe or a device; name a file")
    if path.exists() and not force:
        raise ValueError(f"{path}: is there already; name another file, or replace it with --force")
    if not os.access(path.resolve().parent, os.W_OK):
        raise ValueError(f"{path.parent}: no permission to write there")


def check_apart(outputs: Mapping[str, Path | None], inputs: Mapping[str, str | Path]) -> None:
    """See that no output is an input or another output, by whatever path or link.

    Args:
        outputs: files to write, by what the user calls them; None where there is none.
        inputs: files to read, by what the user calls them.

    Raises:
        ValueError: two are the same file.
    """
    others = {name: Path(path) for name, path in inputs.items()}
    for name, path in outputs.items():
        if path is None:
            continue
        for other, taken in others.items():
            if _same(path, taken):
                raise ValueError(f"{path}: {name} is {other} itself; name another file")
        others[name] = path


def _same(a: Path, b: Path) -> bool:
    return a.resolve() == b.resolve() or (a.exists() and b.exists() and a.samefile(b))


@contextmanager
def written_beside(path: str | Path) -> Iterator[Path]:
    """A file to write beside its place; it takes the place when all of it is on disk, and vanishes on any error.

    Raises:
        OSError: it cannot be written; the message names the place.
    """
    path = Path(path).resolve()  # a link stays, and what it leads to is replaced
    temporary = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    try:
        yield temporary
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())  # some disks tell only now that they are full
        temporary.replace(path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error  # the user knows this name
        raise


def write_whole(path: str | Path, content: bytes) -> None:
    """Write a file so that one already there is replaced only by a whole one."""
    with written_beside(path) as temporary:
        temporary.write_bytes(content)
