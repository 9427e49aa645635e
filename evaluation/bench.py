"""The speed figures: what a step of the world, a decision and a comparison cost on this machine.

Every figure is a median over repetitions in one run. Machines are shared and noisy: compare figures of one
run with each other, not with those of another day.
"""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from indoor_explorers.env import InputError, Scenario, World, make_policy, parallel_env
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.maps.sources import ThesisMaps
from indoor_explorers.env.presets import scenario
from indoor_explorers.env.registry import policy_entry_points
from indoor_explorers.env.scenario import Lidar, Radio
from indoor_explorers.evaluation.compare import plan, run
from indoor_explorers.evaluation.experiment import Task
from indoor_explorers.evaluation.runner import fly

REPEATS = 5
#: Settings under which random moves do not end an episode early.
UNENDING = {"on_collision": "block", "stuck.rule": "off", "goal": 1.0, "denominator": "reachable"}


class Figure(NamedTuple):
    """One measured figure."""

    name: str
    value: float
    unit: str


def square(side: int, lidar_range: float, team: int, radio: float) -> Scenario:
    """Return a square room with about the thesis's density of obstacles, whose walls only cost a step."""
    return Scenario(
        name=f"{side}x{side}",
        map=ThesisMaps(height=side, width=side, obstacles=5 * side * side // 256),
        team=team,
        lidar=Lidar(range=lidar_range),
        radio=Radio(model="square", range=radio) if team > 1 else Radio(),
        on_collision="block",
        goal=1.0,
        goal_of="team",
        budget=400,
    )


#: Worlds whose speed is measured: (scenario, episodes in a batch).
WORLDS = {
    "world-16x16-lidar3-team1": (square(16, 3.0, 1, 0.0), 256),
    "world-16x16-lidar3-team4": (square(16, 3.0, 4, 3.0), 128),
    "world-64x64-lidar10-team4": (square(64, 10.0, 4, 10.0), 32),
    "world-250x250-lidar35-team2": (square(250, 35.0, 2, 35.0), 4),
}


def figures(*, everything: bool = False) -> Iterator[Figure]:
    """Measure and yield one figure after the other; ``everything`` adds those that take minutes."""
    yield Figure("first-compile", first_compile(), "s")
    for name, (task, batch) in WORLDS.items():
        yield Figure(name, world_speed(task, batch), "agent-steps/s")
    yield Figure("gym-step", gymnasium_step(), "us")
    if importlib.util.find_spec("pettingzoo"):
        yield Figure("pettingzoo-step-team4", pettingzoo_step(), "us")
    for side, lidar_range in ((16, 3.0), (250, 10.0)):
        for policy in policy_entry_points():
            yield Figure(f"decide-{policy}-{side}x{side}", decision_time(policy, side, lidar_range), "us")
    yield Figure("harness-1000-episodes", comparison_time(1000), "s")
    if everything:
        yield Figure("harness-10000-episodes", comparison_time(10_000), "s")


def world_speed(task: Scenario, batch: int, steps: int = 400) -> float:
    """Return agent-steps a second under random moves: rewards, ends, beliefs and new episodes included."""
    world = World(task, batch)
    seeds = iter(range(10**9))
    world.reset([next(seeds) for _ in range(batch)])
    actions = np.random.default_rng(0).integers(0, 4, (64, batch, task.team))

    def fly_on() -> None:
        for step in range(steps):
            world.step(actions[step % 64])
            for episode in np.flatnonzero(~world.flying.any(axis=1)):
                world.begin(int(episode), next(seeds))

    return steps * batch * task.team / _median_seconds(fly_on)


def gymnasium_step(steps: int = 2000) -> float:
    """Return the microseconds of a step of the Gymnasium environment with its default observation, resets left out."""
    import gymnasium

    env = gymnasium.make("indoor_explorers.env:IndoorExplorers-v0", settings=UNENDING)
    actions = np.random.default_rng(0).integers(0, 4, steps)
    seconds = []
    env.reset(seed=0)
    for action in actions:
        start = time.perf_counter()
        _, _, terminated, truncated, _ = env.step(action)
        seconds.append(time.perf_counter() - start)
        if terminated or truncated:
            env.reset()
    return float(np.median(seconds)) * 1e6


def pettingzoo_step(steps: int = 2000) -> float:
    """Return the microseconds of a step of four UAVs in the PettingZoo environment, resets left out."""
    env = parallel_env(scenario="thesis-team-4", settings=UNENDING)
    rng, seconds = np.random.default_rng(0), []
    env.reset(seed=0)
    for _ in range(steps):
        actions = dict(zip(env.agents, rng.integers(0, 4, len(env.agents)), strict=True))
        start = time.perf_counter()
        env.step(actions)
        seconds.append(time.perf_counter() - start)
        if not env.agents:
            env.reset()
    return float(np.median(seconds)) * 1e6


def decision_time(policy: str, side: int, lidar_range: float) -> float:
    """Return the median microseconds of a decision, following plans included, of two UAVs on a square map."""
    task = square(side, lidar_range, 2, 3 * lidar_range).with_settings({"budget": 200})
    pilot = make_policy(policy)
    medians = []
    for seed in range(REPEATS + 1):
        (record,) = fly(pilot, policy, task, [Task(task.name, 0, seed)])
        medians.append(record.metrics["latency_p50_us"] or np.nan)
    return float(np.median(medians[1:]))


def comparison_time(episodes: int) -> float:
    """Return the seconds of a whole comparison with ``frontier-nearest``: workers, store, table and report."""
    planned = plan(policies=["frontier-nearest"], scenario=scenario("thesis-obstacles"), episodes=episodes)
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        run(planned, Path(folder) / "out")
        return time.perf_counter() - start


def first_compile() -> float:
    """Return the seconds from nothing compiled to the first step of a world, in a process of its own."""
    code = (
        "from indoor_explorers.env import World, scenario; import numpy as np;"
        "w = World(scenario('thesis-team-4')); w.reset([0]); w.step(np.zeros((1, 4), int))"
    )
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True, env=os.environ | {"NUMBA_CACHE_DIR": folder})
        return time.perf_counter() - start


def _median_seconds(work: Callable[[], None]) -> float:
    work()
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return float(np.median(seconds))


def write_json(measured: list[Figure], path: Path) -> None:
    """Write figures as a list of objects with name, value and unit."""
    try:
        with written_whole(path) as partial:
            partial.write_text(json.dumps([figure._asdict() for figure in measured], indent=1) + "\n")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}; choose another --json") from error
