"""Greedy evaluation, apart from training: on maps of its own, without exploration, all UAVs by the network."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End
from indoor_explorers.learners.sessions.evaluation import T90
from indoor_explorers.learners.thesis.vector_flight import ImageFlight


class GreedyFigures(NamedTuple):
    """How the network did at one moment of the training; coverage is the team's, as the task counts it."""

    episodes: int
    """Training episodes flown by then."""
    score: float
    """Mean sum of a UAV's rewards."""
    coverage: float
    """Mean coverage at the end."""
    t90: float
    """Mean steps to 90 % coverage; the budget where it was not reached, however early the episode ended."""
    reached: float
    """Share of the episodes that got to 90 %."""
    crashed: float
    """Share of the UAVs that flew into an obstacle or off the map."""
    stuck: float
    """Share of the UAVs that the stuck rule ended."""


def evaluate(
    choose: Callable[[NDArray[np.uint8]], NDArray[np.int64]],
    task: Scenario,
    episodes: int,
    first_seed: int,
    trained: int,
    *,
    frames: int,
    identity: bool,
) -> tuple[GreedyFigures, list[float]]:
    """Fly ``episodes`` episodes with seeds from ``first_seed`` on, after ``trained`` episodes of training.

    ``choose`` maps images (P, K, H, W) to moves. Also returns the mean coverage after 0, 1, 2, ... steps; an episode
    that has ended keeps its own.
    """
    seeds = iter(range(first_seed, first_seed + episodes))
    team = range(task.team)
    flight = ImageFlight(task, episodes, lambda: next(seeds), frames=frames, identity=identity, pilots=team)
    world, score = flight.world, np.zeros(flight.columns)
    curve = [world.team_coverage]
    while len(flying := np.flatnonzero(flight.end == End.FLYING)):
        actions = np.zeros(flight.columns, np.int64)
        actions[flying] = choose(flight.images[flying])
        flight.step(actions, flying)
        score += world.state.reward.ravel()
        curve.append(world.team_coverage)
    figures = _figures(np.array(curve), world.state.budget, score, flight.end, trained)
    return figures, [round(float(share), 4) for share in np.mean(curve, axis=1)]


def _figures(
    curve: NDArray[np.float64],
    budget: NDArray[np.int64],
    score: NDArray[np.float64],
    end: NDArray[np.uint8],
    trained: int,
) -> GreedyFigures:
    enough = curve >= T90
    reached = enough.any(axis=0)
    return GreedyFigures(
        episodes=trained,
        score=float(score.mean()),
        coverage=float(curve[-1].mean()),
        t90=float(np.where(reached, enough.argmax(axis=0), budget).mean()),
        reached=float(reached.mean()),
        crashed=float(np.isin(end, (End.COLLISION, End.OUT_OF_BOUNDS)).mean()),
        stuck=float((end == End.STUCK).mean()),
    )
