"""Who flies where: joint goal assignments of a group of UAVs, their fitness, and good ones to start from.

An assignment is (N,) int: for each UAV the number of its goal among K candidates. Higher fitness is better.
"""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.compiled import kernel
from indoor_explorers.env.grid import UNREACHABLE
from indoor_explorers.planners.gains import bit_count

Assignment = NDArray[np.int64]


class Task(NamedTuple):
    """One joint decision: N UAVs, each of which can reach at least one of K candidate goals."""

    steps: NDArray[np.float64]
    """(N, K) path lengths in steps; ``UNREACHABLE`` where there is no path."""
    points: NDArray[np.float64]
    """(K, 2) row and column of the candidates."""
    sights: NDArray[np.uint64]
    """(K, words) unknown cells visible from each candidate, as bits."""
    lidar_range: float
    """R, in cells."""
    weights: NDArray[np.float64]
    """(4,) weights of union view gain, mean distance, crowding and imbalance."""


@kernel()
def _union(sights: np.ndarray, goals: np.ndarray) -> int:
    """Count the cells visible from at least one of the goals."""
    gain = 0
    for word in range(sights.shape[1]):
        joint = np.uint64(0)
        for i in range(goals.shape[0]):
            joint |= sights[goals[i], word]
        gain += int(bit_count(joint))
    return gain


@kernel()
def _crowding(points: np.ndarray, goals: np.ndarray, lidar_range: float) -> float:
    """Sum over pairs of goals how much nearer than the lidar range they are, 0 to 1 a pair."""
    crowding = 0.0
    for i in range(goals.shape[0]):
        for k in range(i):
            rows = points[goals[i], 0] - points[goals[k], 0]
            cols = points[goals[i], 1] - points[goals[k], 1]
            crowding += max(0.0, 1.0 - np.sqrt(rows * rows + cols * cols) / lidar_range)
    return crowding


@kernel()
def fitness(task: Task, goals: np.ndarray) -> float:
    """Return how good it is that UAV i flies to candidate ``goals[i]``.

    Union view gain / (pi R^2 N) - mean d / R - crowding - (max d - mean d) / R, each with its weight.
    """
    count, reach = goals.shape[0], task.lidar_range
    total = longest = 0.0
    for i in range(count):
        steps = task.steps[i, goals[i]]
        total += steps
        longest = max(longest, steps)
    mean = total / count
    return float(
        task.weights[0] * _union(task.sights, goals) / (pi * reach * reach * count)
        - task.weights[1] * mean / reach
        - task.weights[2] * _crowding(task.points, goals, reach)
        - task.weights[3] * (longest - mean) / reach
    )


def options(task: Task) -> tuple[Assignment, Assignment]:
    """Return each UAV's reachable candidates, nearest first, (N, K), and how many those are, (N,)."""
    return np.argsort(task.steps, axis=1, kind="stable"), (task.steps < UNREACHABLE).sum(axis=1)


def by_hungarian(task: Task) -> Assignment:
    """Return the assignment of least total distance (Kuhn 1955).

    With fewer candidates than UAVs every candidate takes ceil(N / K) of them, all but one at an extra
    cost of R. A UAV that is left only what it cannot reach goes to its nearest candidate.
    """
    from scipy.optimize import linear_sum_assignment

    uavs, candidates = task.steps.shape
    copies = -(-uavs // candidates)
    cost = np.concatenate([task.steps + (task.lidar_range if copy else 0.0) for copy in range(copies)], axis=1)
    columns = linear_sum_assignment(cost)[1] % candidates
    return reachable_or_nearest(task, np.asarray(columns, np.int64))


def by_minpos(task: Task) -> Assignment:
    """Return for every UAV the candidate that the fewest others are nearer to, the nearest of those (Bautin 2012)."""
    steps = task.steps
    nearer = steps[:, None, :] > steps[None, :, :]
    first = np.tri(len(steps), k=-1, dtype=bool)[:, :, None] & (steps[:, None, :] == steps[None, :, :])
    rank = (nearer | first).sum(axis=1)
    rank[steps >= UNREACHABLE] = len(steps) + 1
    return np.array([np.lexsort((steps[i], rank[i]))[0] for i in range(len(steps))], np.int64)


def reachable_or_nearest(task: Task, goals: Assignment) -> Assignment:
    """Replace goals that a UAV cannot reach, and missing ones (-1), by its nearest candidate."""
    rows = np.arange(len(goals))
    bad = (goals < 0) | (task.steps[rows, goals] >= UNREACHABLE)
    return np.where(bad, task.steps.argmin(axis=1), goals)
