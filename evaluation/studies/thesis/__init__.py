"""Repeats every experiment of the IndoorExplorers thesis, as it was and with its mistakes corrected."""

from indoor_explorers.evaluation.studies.thesis.running import run_thesis

__all__ = ["run_thesis"]
