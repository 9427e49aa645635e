"""Benchmarks of a step through the interfaces: Gymnasium, PettingZoo and the vector environment."""

from __future__ import annotations

import time

import numpy as np

from indoor_explorers.env import parallel_env
from indoor_explorers.evaluation.studies.bench.figure import median_of, seconds_of
from indoor_explorers.evaluation.studies.bench.worlds import random_moves

#: Settings under which random moves do not end an episode early.
UNENDING = {"on_collision": "block", "stuck.rule": "off", "goal": 1.0, "denominator": "reachable"}


def gymnasium_step(steps: int = 2000) -> float:
    """Return the microseconds of a step of the Gymnasium environment with its default observation, without resets."""
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
    """Return the microseconds of a step of four UAVs in the PettingZoo environment, without resets."""
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
