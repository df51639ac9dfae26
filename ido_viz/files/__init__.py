"""Everything that leaves the page."""
