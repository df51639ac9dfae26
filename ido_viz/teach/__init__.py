"""Lessons, presets and derivations."""
