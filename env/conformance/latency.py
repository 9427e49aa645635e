"""Decision times of one UAV in a small room and of a team on a large map: a report that never fails."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from indoor_explorers.env.conformance.flying import one_by_one, together
from indoor_explorers.env.conformance.harness import FIRST, LARGE, SOLO, STEPS, Harness
from indoor_explorers.env.scenarios.scenario import Scenario

#: Steps flown on the large map.
LARGE_STEPS = 100
#: A decision that takes longer is counted, in seconds.
LIMIT = 5e-3
#: Decisions get slower when the last quarter's median is this many times the first's, and this many seconds above it.
SLOWER_FACTOR, SLOWER_SECONDS = 2.0, 50e-6


def report_latency(harness: Harness) -> str:
    """Time one UAV in a room, 16x16 unless the policy flies another size."""
    height, width = harness.map_shape or (16, 16)
    return f"one UAV, {height}x{width}: {latency_text(_timed(harness, SOLO, STEPS))}"


def report_large_latency(harness: Harness) -> str:
    """Time four UAVs on a 64x64 map, if the policy flies one."""
    if harness.map_shape is not None:
        return "not timed: the policy's map_shape says that it flies maps of one size"
    shares = "; each time a UAV's share of a batch" if harness.policy.batched else ""
    return f"four UAVs, 64x64: {latency_text(_timed(harness, LARGE, LARGE_STEPS))}{shares}"


def _timed(harness: Harness, scenario: Scenario, steps: int) -> list[float]:
    """Return decision times in seconds; earlier flights have loaded and compiled everything."""
    (trace,) = harness.fly(scenario, [FIRST], steps, ask=together if harness.policy.batched else one_by_one)
    return trace.seconds


def latency_text(seconds: Sequence[float]) -> str:
    """Describe decision times in order: median, 99th percentile, slowest, and whether they increase."""
    times = np.asarray(seconds)
    share = float(np.mean(times > LIMIT))
    figures = (("median", np.percentile(times, 50)), ("p99", np.percentile(times, 99)), ("slowest", times.max()))
    text = ", ".join(f"{name} {_time(float(value))}" for name, value in figures)
    text += f"; {100 * share:.1f} % over 5 ms" if share else "; none over 5 ms"
    quarter = max(1, len(times) // 4)
    first, last = float(np.median(times[:quarter])), float(np.median(times[-quarter:]))
    if last > SLOWER_FACTOR * first and last > first + SLOWER_SECONDS:
        text += f"; gets slower: median {_time(first)} in the first quarter, {_time(last)} in the last"
    return text


def _time(seconds: float) -> str:
    return f"{seconds * 1e6:.0f} us" if seconds < 1e-3 else f"{seconds * 1e3:.1f} ms"
