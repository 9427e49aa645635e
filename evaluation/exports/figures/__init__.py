"""Figures for print."""

from indoor_explorers.evaluation.exports.figures.writing import write_figures

__all__ = ["write_figures"]
