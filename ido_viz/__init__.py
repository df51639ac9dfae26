"""The explorer: `ido-viz` on the command line, `ido_viz.show` in a notebook."""

from ido_viz.notebook import Page, show

__all__ = ["Page", "show"]
