"""The explorer: `ido-viz` on the command line, `ido_viz.show` in a notebook."""

from ido_viz.notebook import EmbeddedExplorer, show

__all__ = ["EmbeddedExplorer", "show"]
