"""What a step costs through the environments' faces, what starting costs, and what a scan costs."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time

import numpy as np

from indoor_explorers.env import World, parallel_env
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, lidar_model, new_scan, visible_cells
from indoor_explorers.evaluation.bench.figure import median_of, seconds_of
from indoor_explorers.evaluation.bench.worlds import random_moves, square

#: Settings under which random moves do not end an episode early.
UNENDING = {"on_collision": "block", "stuck.rule": "off", "goal": 1.0, "denominator": "reachable"}
FIRST_STEP = (
    "from indoor_explorers.env import World, scenario; import numpy as np;"
    "w = World(scenario('thesis-team-4')); w.reset([0]); w.step(np.zeros((1, 4), int))"
)


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


def vector_speed(num_envs: int, steps: int = 400) -> float:
    """Return env-steps a second of the native vector environment with its default observation, resets included."""
    from indoor_explorers.env.interfaces.vector import IndoorExplorersVectorEnv

    env = IndoorExplorersVectorEnv(num_envs, settings=UNENDING)
    actions = random_moves(num_envs, 1)[..., 0]
    env.reset(seed=0)

    def fly() -> float:
        return seconds_of(lambda: [env.step(actions[step % len(actions)]) for step in range(steps)])

    return steps * num_envs / median_of(fly)


@kernel()
def _scan_all(truth: np.ndarray, places: np.ndarray, lidar: LidarModel, work: Scan) -> int:
    """Scan from each of the places (K, 2); return the cells seen."""
    seen = 0
    for k in range(places.shape[0]):
        seen += visible_cells(truth, places[k, 0], places[k, 1], lidar, work)
    return seen


def scan_time(lidar_range: float, scans: int = 1000) -> float:
    """Return the microseconds of a scan from random free cells of a room of 250x250 with obstacles."""
    world = World(square(250, lidar_range, 1))
    world.reset([0])
    truth, lidar = world.state.truth[0], lidar_model(lidar_range)
    places = np.random.default_rng(0).permutation(np.argwhere(truth == FREE))[:scans]
    work = new_scan(lidar)
    return median_of(lambda: seconds_of(lambda: _scan_all(truth, places, lidar, work))) / len(places) * 1e6


def first_compile() -> float:
    """Return the seconds from nothing compiled to the first step of a world, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        return _first_step({"NUMBA_CACHE_DIR": folder})


def first_step() -> float:
    """Return the seconds of a new process to its first step of a world when everything is compiled."""
    return median_of(lambda: _first_step({}))


def _first_step(variables: dict[str, str]) -> float:
    """Return the seconds of a process that imports the world and makes one step, its own start included."""
    command, variables = [sys.executable, "-P", "-c", FIRST_STEP], os.environ | variables
    return seconds_of(lambda: subprocess.run(command, check=True, env=variables, capture_output=True))
