"""Analyses behind tables, charts and panels: comparisons, times by task, sweeps, coverage axes, failures."""
