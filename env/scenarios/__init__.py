"""Scenarios: the description of a task, presets with a name, and reading both from files."""
