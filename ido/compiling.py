"""Compiling numerical loops: kept on disk between starts where that is possible, and without it where not."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

from numba import njit

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


@cache
def _tell() -> None:
    """Once for all loops."""
    warnings.warn(
        "compiled loops cannot be kept on disk, so every start compiles them anew; let NUMBA_CACHE_DIR name a folder "
        "that can be written to",
        RuntimeWarning,
        stacklevel=3,
    )
