"""The speed figures: what a step of the world, a decision and a comparison cost on this machine.

Every speed is a median over repetitions in one run. Machines are shared and noisy: compare figures of one
run with each other, not with those of another day.
"""

from __future__ import annotations

from indoor_explorers.evaluation.bench.drawing import write_growth
from indoor_explorers.evaluation.bench.figure import Benchmark, Figure, write_json
from indoor_explorers.evaluation.bench.suite import chosen, measures
from indoor_explorers.evaluation.bench.table import measured

__all__ = ["Benchmark", "Figure", "chosen", "measured", "measures", "write_growth", "write_json"]
