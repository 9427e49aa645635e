"""Particle swarm optimisation of joint assignments by random keys (Kennedy & Eberhart 1995; Bean 1994)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.compiled import kernel
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.swarm.assignment import Assignment, Task, fitness, options


@dataclass(frozen=True, kw_only=True)
class Swarm:
    """The parameters of a particle swarm. Positions are keys in [0, 1), one for each UAV.

    J. Kennedy, R. Eberhart, "Particle swarm optimization", ICNN 1995, doi:10.1109/ICNN.1995.488968;
    inertia that falls linearly as in Y. Shi, R. Eberhart, CEC 1998, doi:10.1109/ICEC.1998.699146.
    """

    particles: int = 20
    """How many."""
    rounds: int = 30
    """At most."""
    inertia: tuple[float, float] = (0.9, 0.4)
    """Share of its velocity that a particle keeps, in the first and in the last round."""
    cognitive: float = 1.5
    """Pull of a particle's own best position."""
    social: float = 1.5
    """Pull of the swarm's best position."""
    largest_step: float = 0.3
    """Fastest change of a key in a round."""
    stagnation: int = 8
    """Rounds without a better assignment after which the swarm stops."""

    def __post_init__(self) -> None:
        at_least(self, 1, "particles", "stagnation")
        at_least(self, 0, "rounds", "cognitive", "social", "largest_step")


@kernel()
def _decode(keys: np.ndarray, choices: np.ndarray, counts: np.ndarray, out: np.ndarray) -> None:
    for i in range(keys.shape[0]):
        out[i] = choices[i, min(int(keys[i] * counts[i]), counts[i] - 1)]


@kernel()
def _advance(
    keys: np.ndarray, speed: np.ndarray, best: np.ndarray, leader: np.ndarray, chance: np.ndarray, pull: np.ndarray
) -> None:
    """Move one particle; ``chance`` is (2, N) in [0, 1), ``pull`` inertia, cognitive, social and largest step."""
    for i in range(keys.shape[0]):
        change = (
            pull[0] * speed[i]
            + pull[1] * chance[0, i] * (best[i] - keys[i])
            + pull[2] * chance[1, i] * (leader[i] - keys[i])
        )
        speed[i] = min(max(change, -pull[3]), pull[3])
        keys[i] = min(max(keys[i] + speed[i], 0.0), 1.0)


@kernel()
def _evolve(
    task: Task,
    choices: np.ndarray,
    counts: np.ndarray,
    keys: np.ndarray,
    chances: np.ndarray,
    pulls: np.ndarray,
    stagnation: int,
) -> np.ndarray:
    """Run the swarm from (S, N) ``keys``; ``chances`` is (T, S, 2, N) and ``pulls`` (T, 4). Return the best (N,)."""
    particles, uavs = keys.shape
    speeds = np.zeros((particles, uavs))
    own, own_fitness = keys.copy(), np.full(particles, -np.inf)
    goals, leader, leading = np.empty(uavs, np.int64), 0, -np.inf
    idle = 0
    for t in range(chances.shape[0] + 1):
        idle += 1
        for s in range(particles):
            _decode(keys[s], choices, counts, goals)
            value = fitness(task, goals)
            if value > own_fitness[s]:
                own_fitness[s], own[s] = value, keys[s]
            if value > leading:
                leading, leader, idle = value, s, 0
        if t == chances.shape[0] or idle >= stagnation:
            break
        for s in range(particles):
            _advance(keys[s], speeds[s], own[s], own[leader], chances[t, s], pulls[t])
    _decode(own[leader], choices, counts, goals)
    return goals


def keys_of(goals: Assignment, choices: Assignment, counts: Assignment) -> NDArray[np.float64]:
    """Return the (N,) keys in the middle of what decodes to ``goals``."""
    places = (choices == goals[:, None]).argmax(axis=1)
    return np.asarray((places + 0.5) / counts, np.float64)


def optimise(task: Task, swarm: Swarm, seeds: Sequence[Assignment], rng: np.random.Generator) -> Assignment:
    """Return the best assignment that a swarm finds, never one of less fitness than any of ``seeds``.

    UAV i's key picks among its reachable candidates in order of distance; one particle starts at each of the
    seeds, which must be reachable, the others anywhere.
    """
    choices, counts = options(task)
    keys = rng.random((max(swarm.particles, len(seeds)), len(counts)))
    for place, goals in enumerate(seeds):
        keys[place] = keys_of(goals, choices, counts)
    chances = rng.random((swarm.rounds, len(keys), 2, len(counts)))
    pulls = np.empty((swarm.rounds, 4))
    pulls[:, 0] = np.linspace(*swarm.inertia, swarm.rounds)
    pulls[:, 1:] = swarm.cognitive, swarm.social, swarm.largest_step
    return np.asarray(_evolve(task, choices, counts, keys, chances, pulls, swarm.stagnation))
