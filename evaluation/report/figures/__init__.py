"""Figures for print."""

from indoor_explorers.evaluation.report.figures.writing import write_figures

__all__ = ["write_figures"]
