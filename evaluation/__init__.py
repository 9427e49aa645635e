"""Experiments, their results and reports."""
