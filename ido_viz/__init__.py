"""The explorer: `ido-viz` on the command line, `ido_viz.show` in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ido_viz.notebook import EmbeddedExplorer, show

__all__ = ["EmbeddedExplorer", "show"]


def __getattr__(name: str) -> Any:
    """What is imported when it is asked for: it takes seconds, in which the command must answer to Ctrl-C."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from ido_viz import notebook

    return getattr(notebook, name)
