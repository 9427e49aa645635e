"""Benchmarks: the time of a step of the world, of a decision and of a comparison on this machine.

Every speed is a median over repetitions. Machines are shared and noisy: compare figures of one run, not of
different days.
"""

from __future__ import annotations

from indoor_explorers.evaluation.studies.bench.drawing import write_growth
from indoor_explorers.evaluation.studies.bench.figure import Benchmark, Figure, measured, write_json
from indoor_explorers.evaluation.studies.bench.suite import chosen, measures

__all__ = ["Benchmark", "Figure", "chosen", "measured", "measures", "write_growth", "write_json"]
