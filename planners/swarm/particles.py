"""Particle swarm optimisation of joint plans by random keys (Bean 1994): a key in [0, 1) for each goal of each UAV.

J. Kennedy, R. Eberhart, "Particle swarm optimization", ICNN 1995, doi:10.1109/ICNN.1995.488968.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.planners.swarm.assignment import Assignment, AssignmentProblem, Plan, choices, followers, value

#: Number of best next goals that a key selects from.
FOLLOWERS = 8


#: Share of its velocity that a particle keeps, in the first and in the last iteration (linear in between, as in
#: Y. Shi, R. Eberhart, CEC 1998, doi:10.1109/ICEC.1998.699146).
INERTIA = (0.9, 0.4)
#: Attraction of a particle's own best position, and of the swarm's.
COGNITIVE, SOCIAL = 1.5, 1.5
#: Largest change of a key in an iteration.
LARGEST_STEP = 0.3
#: Iterations without a better plan after which the swarm stops.
STAGNATION = 8


class Code(NamedTuple):
    """The decoding of keys: a UAV's first key selects one of its candidates, each other key a next goal."""

    choices: Assignment
    """(N, K) each UAV's candidates, best first."""
    counts: Assignment
    """(N,) number of candidates that it can reach."""
    followers: Assignment
    """(K, M) the best candidates to visit after each candidate, best first."""


@leaf(entry=False)
def _next(code: Code, plan: np.ndarray, turn: int, key: float) -> int:
    """Return the next goal that a key selects after a UAV's last one, not in its (L,) plan yet; -1 for none."""
    options = code.followers[plan[turn - 1]]
    pick, goal = min(int(key * FOLLOWERS), FOLLOWERS - 1), -1
    for place in range(options.shape[0]):
        taken = False
        for before in range(turn):
            taken |= plan[before] == options[place]
        if not taken:
            goal = options[place]
            if pick == 0:
                break
            pick -= 1
    return goal


@leaf()
def decode(keys: np.ndarray, code: Code, out: np.ndarray) -> None:
    """Decode (N, L) keys to the plan ``out`` (N, L)."""
    for i in range(keys.shape[0]):
        out[i, :] = -1
        out[i, 0] = code.choices[i, min(int(keys[i, 0] * code.counts[i]), code.counts[i] - 1)]
        for turn in range(1, keys.shape[1]):
            out[i, turn] = _next(code, out[i], turn, keys[i, turn])
            if out[i, turn] < 0:
                break


@leaf(entry=False)
def _advance(
    keys: np.ndarray, speed: np.ndarray, best: np.ndarray, leader: np.ndarray, chance: np.ndarray, pull: np.ndarray
) -> None:
    """Move one particle; ``chance`` is (2, D) in [0, 1), ``pull`` inertia, cognitive, social and largest step."""
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
    problem: AssignmentProblem,
    code: Code,
    keys: np.ndarray,
    own_value: np.ndarray,
    length: int,
    chances: np.ndarray,
    pulls: np.ndarray,
    stagnation: int,
) -> np.ndarray:
    """Run the swarm from (S, N L) ``keys`` and return the best plan (N, L).

    ``own_value`` (S,) is -inf at first; ``chances`` is (T, S, 2, N L), ``pulls`` (T, 4).
    """
    particles, size = keys.shape
    speeds, own = np.zeros((particles, size)), keys.copy()
    plan, order, times = np.empty((size // length, length), np.int64), np.empty(size, np.int64), np.empty(size)
    leader, leading, idle = 0, -np.inf, 0
    for t in range(chances.shape[0] + 1):
        idle += 1
        for s in range(particles):
            decode(keys[s].reshape(plan.shape), code, plan)
            found = value(problem, plan, order, times)
            if found > own_value[s]:
                own_value[s] = found
                for i in range(size):
                    own[s, i] = keys[s, i]
            if found > leading:
                leading, leader, idle = found, s, 0
        if t == chances.shape[0] or idle >= stagnation:
            break
        for s in range(particles):
            _advance(keys[s], speeds[s], own[s], own[leader], chances[t, s], pulls[t])
    decode(own[leader].reshape(plan.shape), code, plan)
    return plan


def code_of(problem: AssignmentProblem, length: int) -> Code:
    """Return the decoding of keys of plans with ``length`` goals per UAV."""
    return Code(*choices(problem), np.ascontiguousarray(followers(problem, FOLLOWERS + length)))


def keys_of(goals: Assignment, code: Code, length: int) -> NDArray[np.float64]:
    """Return (N, L) keys that decode to ``goals`` first, then always to the best next goal."""
    keys = np.zeros((len(goals), length))
    places = (code.choices == goals[:, None]).argmax(axis=1)
    keys[:, 0] = (places + 0.5) / code.counts
    return keys


def initial_keys(
    code: Code, length: int, seeds: Sequence[Assignment], count: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the keys of a swarm of ``count`` or more, (S, N L): one for each of the ``seeds``, the others random.

    The seeds, assignments that must be reachable, are continued by the best next goals. More of the random positions
    are near the best candidates.
    """
    keys: NDArray[np.float64] = rng.random((max(count, len(seeds)), len(code.counts) * length)) ** 2
    for place, goals in enumerate(seeds):
        keys[place] = keys_of(goals, code, length).ravel()
    return keys


def optimise(
    problem: AssignmentProblem,
    length: int,
    seeds: Sequence[Assignment],
    particles: int,
    rounds: int,
    rng: np.random.Generator,
) -> Plan:
    """Return the best plan of ``length`` goals per UAV that a swarm finds in ``rounds`` iterations, (N, L).

    A UAV's first key selects among its reachable candidates, best first, each other key among the best next goals. The
    plan never has a lower fitness than the initial plans of the ``seeds`` (:func:`initial_keys`).
    """
    code = code_of(problem, length)
    keys = initial_keys(code, length, seeds, particles, rng)
    chances = rng.random((rounds, len(keys), 2, keys.shape[1]))
    pulls = np.empty((rounds, 4))
    pulls[:, 0] = np.linspace(*INERTIA, rounds)
    pulls[:, 1:] = COGNITIVE, SOCIAL, LARGEST_STEP
    unknown = np.full(len(keys), -np.inf)
    return np.asarray(_evolve(problem, code, keys, unknown, length, chances, pulls, STAGNATION))
