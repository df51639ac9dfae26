"""Clouds, trained maps and results that ship with the program; ATTRIBUTION.md says where they come from."""
