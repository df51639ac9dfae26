"""The docked panels: controls, charts, tables."""
