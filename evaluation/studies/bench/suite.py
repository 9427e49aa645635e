"""All benchmarks: their names, units and order."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator, Sequence
from fnmatch import fnmatchcase
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.policies.registry import policy_entry_points
from indoor_explorers.evaluation.harness.engines.workload import JOB_EPISODES
from indoor_explorers.evaluation.studies.bench import (
    ancestor,
    deciding,
    exploring,
    growth,
    harness,
    interfaces,
    worlds,
)
from indoor_explorers.evaluation.studies.bench.figure import Benchmark, cores
from indoor_explorers.evaluation.studies.bench.worlds import STEPS, WORLDS

SPEED = "agent-steps/s"


def measures(*, everything: bool = False, growing: bool = False) -> list[Benchmark]:
    """Return the benchmarks; ``growing`` adds growth, ``everything`` also the ones that take minutes."""
    found = [*_world(), *_memory(), *_starts(), *_interfaces(), *_lidar(), *_decisions(), *_harness(everything)]
    if growing or everything:
        found += [Benchmark("Growth", name, SPEED, take) for name, take in growth.growth().items()]
        found += [Benchmark("Growth", name, "us", take) for name, take in deciding.growth().items()]
    return found


def chosen(among: Sequence[Benchmark], patterns: Sequence[str]) -> list[Benchmark]:
    """Return the benchmarks whose names match one of the file name patterns."""
    found = [measure for measure in among if any(fnmatchcase(measure.name, pattern) for pattern in patterns)]
    if not found:
        groups = ", ".join(dict.fromkeys(f"{measure.name.split('-')[0]}-*" for measure in among))
        raise InputError(f"expected names of figures such as {groups}, got {','.join(patterns)}")
    return found


def _world() -> Iterator[Benchmark]:
    """Yield the speeds of the worlds, and the ratios of two of them to the ancestor; each speed is measured once."""
    takes = {name: cache(take) for base in WORLDS for name, take in _variants(base)}
    yield from (Benchmark("World", name, SPEED, take) for name, take in takes.items())
    for name, (task, batch) in worlds.UNCERTAIN.items():
        yield Benchmark("World", name, SPEED, partial(worlds.world_speed, task, batch))
    for team in (1, 4):
        name = f"world-16x16-lidar3-team{team}"
        slow = cache(partial(ancestor.ancestor_speed, WORLDS[name][0]))
        yield Benchmark("Ancestor", f"ancestor-16x16-team{team}", SPEED, slow)
        for tail in ("", "-core"):
            ratio = partial(lambda fast, slow: fast() / slow(), takes[name + tail], slow)
            yield Benchmark("Ancestor", f"ratio-to-ancestor-team{team}{tail}", "x", ratio)


def _variants(name: str) -> Iterator[tuple[str, Callable[[], float]]]:
    """Yield a world under random and exploring moves, each with all cores and with one."""
    task, batch = WORLDS[name]
    recorded = cache(partial(exploring.exploring_moves, task, batch, STEPS))
    for kind, moves in (("", lambda: None), ("-exploring", recorded)):
        for tail, threads in (("", cores()), ("-core", 1)):
            yield name + kind + tail, partial(_speed, task, batch, threads, moves)


def _speed(task: Scenario, batch: int, threads: int, moves: Callable[[], NDArray[np.int64] | None]) -> float:
    return worlds.world_speed(task, batch, threads=threads, moves=moves())


def _memory() -> Iterator[Benchmark]:
    for name, (task, _) in WORLDS.items():
        yield Benchmark("Memory", name.replace("world", "memory"), "bytes", partial(worlds.memory, task))


def _starts() -> Iterator[Benchmark]:
    yield Benchmark("Starts", "first-compile", "s", harness.first_compile)
    yield Benchmark("Starts", "first-step", "s", harness.first_step)
    for side, (task, _) in ((16, WORLDS["world-16x16-lidar3-team1"]), (250, WORLDS["world-250x250-lidar35-team2"])):
        yield Benchmark("Starts", f"reset-{side}x{side}", "us", partial(worlds.reset_time, task))


def _interfaces() -> Iterator[Benchmark]:
    yield Benchmark("Interfaces", "gym-step", "us", interfaces.gymnasium_step)
    if importlib.util.find_spec("pettingzoo"):
        yield Benchmark("Interfaces", "pettingzoo-step-team4", "us", interfaces.pettingzoo_step)
    yield Benchmark("Interfaces", "vector-channels-256", "env-steps/s", partial(interfaces.vector_speed, 256))


def _lidar() -> Iterator[Benchmark]:
    for cells in (3, 10, 35):
        yield Benchmark("Lidar", f"lidar-range{cells}", "us", partial(worlds.scan_time, float(cells)))


def _decisions() -> Iterator[Benchmark]:
    for name, take in deciding.figures().items():
        yield Benchmark("Decisions", name, "us", take)


def _harness(everything: bool) -> Iterator[Benchmark]:
    for policy in policy_entry_points():
        yield Benchmark("Harness", f"harness-overhead-{policy}", "%", partial(harness.overhead, policy))
    for tail, pace, episodes in (("", 0.0, JOB_EPISODES), *([("-1ms", 1e-3, JOB_EPISODES // 5)] if everything else [])):
        for team, preset in ((1, "thesis-obstacles"), (4, "thesis-team-4")):
            take = partial(harness.isolation_time, preset, pace, episodes)
            yield Benchmark("Harness", f"isolation-16x16-team{team}{tail}", "us", take)
    for episodes in (1000, 10_000) if everything else (1000,):
        take = partial(harness.comparison_time, episodes)
        yield Benchmark("Harness", f"harness-{episodes}-episodes", "s", take)
    if everything and importlib.util.find_spec("torch"):
        for preset, name in (("thesis-open-quick", ""), ("thesis-open-map", "-map-alone")):
            seconds, t90 = (partial(harness.trained, part, preset, 10_000) for part in ("seconds", "t90"))
            yield Benchmark("Harness", f"train-10000-episodes{name}", "s", seconds)
            yield Benchmark("Harness", f"train-10000-episodes{name}-t90", "steps", t90)
