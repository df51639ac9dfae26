"""Compiling numerical loops: kept on disk between starts where that is possible, and without it where not."""

from __future__ import annotations

import sqlite3
import warnings
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from numba import njit
from numba.core.compiler_lock import global_compiler_lock

Loop = TypeVar("Loop", bound=Callable[..., Any])


def compiled(**options: Any) -> Callable[[Loop], Loop]:
    """Makes a decorator that compiles a loop without holding the interpreter's lock.

    Args:
        options: of `numba.njit`.
    """

    def compile_loop(loop: Loop) -> Loop:
        dispatcher: Any = njit(nogil=True, **options)(loop)
        try:
            dispatcher.enable_caching()
        except RuntimeError:  # no folder for it can be written to
            _tell()
        else:
            _forgive(dispatcher._cache)  # numba offers no other way to outlive what is on disk
            _compile_once(dispatcher)
        return dispatcher

    return compile_loop


def _forgive(kept: Any) -> None:
    """Compile again, and replace it, what is damaged on disk; go on where it cannot be written."""
    load, save = kept.load_overload, kept.save_overload

    def load_overload(*args: Any) -> object:
        try:
            return load(*args)
        except Exception:  # unpickling what is damaged raises all kinds
            try:
                kept.flush()
            except OSError:
                _tell()
            return None

    def save_overload(*args: Any) -> None:
        try:
            save(*args)
        except Exception:
            _tell()

    kept.load_overload, kept.save_overload = load_overload, save_overload


def _compile_once(dispatcher: Any) -> None:
    """Of several processes that need a loop at the same time, one compiles it and the others find it on disk."""
    kept, compile_one = dispatcher._cache, dispatcher.compile
    lock = Path(kept.cache_path) / f"{kept._impl.filename_base}.lock"

    def compile_alone(signature: Any) -> Any:
        with global_compiler_lock, _held(lock):  # in this order, for numba holds its own when a loop calls another
            return compile_one(signature)

    dispatcher.compile = compile_alone


@contextmanager
def _held(file: Path) -> Iterator[None]:
    """Hold a lock that processes share; the system frees it when one dies. Go on where it cannot be had in a minute."""
    try:
        lock = sqlite3.connect(file, timeout=0.1, isolation_level=None)
    except sqlite3.Error:  # no such file can be written
        yield
        return
    with closing(lock):
        for _ in range(600):  # a short wait at a time, which Ctrl-C ends
            try:
                lock.execute("BEGIN EXCLUSIVE")
                break
            except sqlite3.OperationalError as error:
                if error.sqlite_errorcode != sqlite3.SQLITE_BUSY:
                    break
            except sqlite3.Error:  # damaged
                break
        yield


@cache
def _tell() -> None:
    """Once for all loops."""
    warnings.warn(
        "compiled loops cannot be kept on disk, so every start compiles them anew; let NUMBA_CACHE_DIR name a folder "
        "that can be written to",
        RuntimeWarning,
        stacklevel=3,
    )
