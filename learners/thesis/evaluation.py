"""Greedy evaluation on maps that training does not use; the network flies all UAVs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End
from indoor_explorers.learners.sessions.evaluation import T90
from indoor_explorers.learners.thesis.vector_flight import ImageFlight


class GreedyFigures(NamedTuple):
    """Results of the network at one point of the training; coverage is the team's, by the scenario's definition."""

    episodes: int
    """Training episodes flown so far."""
    score: float
    """Mean return of a UAV, undiscounted."""
    coverage: float
    """Mean final coverage."""
    t90: float
    """Mean steps to 90 % coverage; an episode that did not reach it counts with its budget, even if it ended early."""
    reached: float
    """Share of the episodes that reached 90 %."""
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
    centred: bool = False,
) -> tuple[GreedyFigures, list[float]]:
    """Fly ``episodes`` episodes, whose seeds begin at ``first_seed``, after ``trained`` training episodes.

    ``choose`` maps images (P, K, H, W) to moves (P,). Returns the results and the mean coverage after 0, 1, 2, ...
    steps; an episode that has ended counts with its final coverage.
    """
    seeds = iter(range(first_seed, first_seed + episodes))
    team = range(task.team)
    image_settings: dict[str, Any] = {"frames": frames, "identity": identity, "centred": centred}
    flight = ImageFlight(task, episodes, lambda: next(seeds), pilots=team, **image_settings)
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
