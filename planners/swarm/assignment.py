"""Joint plans of a group of UAVs: several goals for each, their fitness, and heuristic initial plans.

A plan is (N, L) int: for each UAV the indices of the goals among K candidates that it visits in turn, -1 for none. An
assignment is (N,), the first goals only. Higher fitness is better.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.planners.toolbox.navigation.teammates import ranks
from indoor_explorers.planners.toolbox.routing.assignment import matched

Assignment = NDArray[np.int64]
Plan = NDArray[np.int64]


class AssignmentProblem(NamedTuple):
    """One joint decision: N UAVs, each of which can reach at least one of K candidate goals."""

    steps: NDArray[np.float64]
    """(N, K) path lengths in steps; ``UNREACHABLE`` where there is no path."""
    hops: NDArray[np.float64]
    """(K, K) path lengths between candidates, in steps."""
    gains: NDArray[np.float64]
    """(K,) view gain of each candidate."""
    shared: NDArray[np.float64]
    """(K, K) share of the first one's view that the second one sees, too."""
    hysteresis: NDArray[np.float64]
    """(N, K) factor on the value of candidate k as the first goal of UAV i."""
    power: float
    """Exponent of the remaining gain; below 1 it raises small gains relative to large ones."""
    rate: float
    """Discount rate of gains per step until arrival."""
    trust: float
    """Factor for every goal that is visited before, since the map may differ from expectation."""
    lidar_range: float
    """Lidar range R in cells."""


@leaf(entry=False)
def _by_arrival(problem: AssignmentProblem, plan: np.ndarray, order: np.ndarray, times: np.ndarray) -> int:
    """Sort the visits i L + turn of a plan by their times of arrival, in steps; return their number."""
    length, count = plan.shape[1], 0
    for i in range(plan.shape[0]):
        time = 0.0
        for turn in range(length):
            if plan[i, turn] < 0:
                break
            time += problem.hops[plan[i, turn - 1], plan[i, turn]] if turn else problem.steps[i, plan[i, turn]]
            place = count
            while place > 0 and times[place - 1] > time:
                times[place], order[place] = times[place - 1], order[place - 1]
                place -= 1
            times[place], order[place] = time, i * length + turn
            count += 1
    return count


@leaf(entry=False)
def value(problem: AssignmentProblem, plan: np.ndarray, order: np.ndarray, times: np.ndarray) -> float:
    """Return the fitness; ``order`` int and ``times`` float are scratch, (N L,) each."""
    length, total = plan.shape[1], 0.0
    count = _by_arrival(problem, plan, order, times)
    for place in range(count):
        i, turn = divmod(order[place], length)
        goal = plan[i, turn]
        gain = problem.gains[goal]
        for before in range(place):
            gain *= 1.0 - problem.shared[goal, plan[order[before] // length, order[before] % length]]
        gain = gain**problem.power * np.exp(-problem.rate * times[place]) * problem.trust**turn
        if turn == 0:
            gain *= problem.hysteresis[i, goal]
        total += gain
    return total


@kernel()
def fitness(problem: AssignmentProblem, plan: np.ndarray) -> float:
    """Return the fitness of a (N, L) joint plan: the union of all views, discounted by the times of arrival.

    It is the sum over all visits of (gain x left)^power e^(-rate t) trust^k, t the time of arrival and k the number of
    goals that the UAV visits before. ``left``, the share of a view that earlier visits have left, is the product of
    1 - shared over them, as if their shares were independent.
    """
    return value(problem, plan, np.empty(plan.size, np.int64), np.empty(plan.size))


def discounted(problem: AssignmentProblem) -> NDArray[np.float64]:
    """Return the value of each candidate to each UAV as its only goal, (N, K); 0 if it is unreachable."""
    worth = problem.hysteresis * problem.gains**problem.power * np.exp(-problem.rate * np.minimum(problem.steps, 1e6))
    return np.where(problem.steps < UNREACHABLE, worth, 0.0)


def choices(problem: AssignmentProblem) -> tuple[Assignment, Assignment]:
    """Return each UAV's reachable candidates, best first, (N, K), and their numbers, (N,)."""
    reachable = problem.steps < UNREACHABLE
    ranks = np.argsort(np.where(reachable, -discounted(problem), np.inf), axis=1, kind="stable")
    return ranks, reachable.sum(axis=1)


def followers(problem: AssignmentProblem, most: int) -> Assignment:
    """Return the ``most`` best candidates to visit after each candidate, best first, (K, most)."""
    worth = (problem.gains * (1.0 - problem.shared.T)) ** problem.power * np.exp(
        -problem.rate * np.minimum(problem.hops, 1e6)
    )
    return np.argsort(-worth, axis=1, kind="stable")[:, :most]


def by_hungarian(problem: AssignmentProblem) -> Assignment:
    """Return the assignment of least total distance; a UAV that shares a candidate costs an extra lidar range.

    A UAV that is assigned an unreachable candidate flies to its nearest one.
    """
    return reachable_or_nearest(problem, matched(problem.steps, problem.lidar_range))


def by_minpos(problem: AssignmentProblem) -> Assignment:
    """Return each UAV's candidate that the fewest others are closer to; among equals the nearest (Bautin 2012)."""
    goals = []
    for i, own in enumerate(problem.steps):
        others = list(np.delete(problem.steps, i, axis=0))
        goals.append(np.lexsort((own, ranks(own, others, [k < i for k in range(len(others))])))[0])
    return np.array(goals, np.int64)


def by_greed(problem: AssignmentProblem) -> Assignment:
    """Return the greedy assignment: repeatedly the pair of UAV and candidate with the largest remaining gain."""
    worth = discounted(problem)
    goals = np.full(len(worth), -1, np.int64)
    for _ in range(len(worth)):
        i, goal = divmod(int(np.where(goals[:, None] < 0, worth, -1.0).argmax()), worth.shape[1])
        goals[i] = goal
        worth = worth * (1.0 - problem.shared[:, goal]) ** problem.power
    return reachable_or_nearest(problem, goals)


def reachable_or_nearest(problem: AssignmentProblem, goals: Assignment) -> Assignment:
    """Replace goals that a UAV cannot reach, and missing ones (-1), by its nearest candidate."""
    rows = np.arange(len(goals))
    bad = (goals < 0) | (problem.steps[rows, goals] >= UNREACHABLE)
    return np.where(bad, problem.steps.argmin(axis=1), goals)
