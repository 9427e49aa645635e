"""Experiments, their results and reports."""

from indoor_explorers.evaluation.compare import compare
from indoor_explorers.evaluation.results import Results

__all__ = ["Results", "compare"]
