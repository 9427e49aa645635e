"""Every experiment of the IndoorExplorers thesis, flown again: as it was, and with its mistakes mended."""

from indoor_explorers.evaluation.thesis.running import run_thesis

__all__ = ["run_thesis"]
