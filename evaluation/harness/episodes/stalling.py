"""Metrics of wasted steps: UAVs that stand still or fly to and fro while there is something left to find.

A UAV has something left to find while it flies and its own map lacks free cells that it can reach. Waiting afterwards
for teammates to finish does not count.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from indoor_explorers.env import World
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.evaluation.harness.episodes.steps import Steps


def behaviour_metrics(world: World, episode: int, steps: Steps, flown: NDArray[np.integer]) -> dict[str, float]:
    """Return ``longest_idle``, ``longest_dither`` and ``idle_share`` of an episode that has ended.

    ``flown`` (N,) is the number of ``steps`` that each UAV flew.
    """
    searching = np.arange(steps.steps)[:, None] < searching_steps(world, episode, steps, flown)
    still = stood_still(steps.cells) & searching
    return {
        "longest_idle": float(longest_run(still)),
        "longest_dither": float(longest_run(to_and_fro(steps.cells) & searching)),
        "idle_share": float(still.sum() / max(1, searching.sum())),
    }


def searching_steps(world: World, episode: int, steps: Steps, flown: NDArray[np.integer]) -> list[int]:
    """Return for each UAV how many steps it began with something left to find."""
    parts, _ = ndimage.label(world.state.truth[episode] == FREE)
    return [
        min(count, _step_complete(world, episode, agent, steps.covered[:, 1 + agent], parts))
        for agent, count in enumerate(flown.tolist())
    ]


def _step_complete(
    world: World, episode: int, agent: int, covered: NDArray[np.integer], parts: NDArray[np.integer]
) -> int:
    """Return the step after which a UAV knew every free cell it could reach; the last of all for never.

    ``parts`` (H, W) labels the connected parts of the map. ``covered`` (S + 1,) is how many counted cells were known
    after each step; the discovery log has the order in which cells became known.
    """
    state = world.state
    if world.scenario.uncertain:  # cells may be known wrongly, and coverage counts those that are right
        part = parts == parts[*state.cell[episode, agent]]
        complete = covered >= int((state.counts[episode] & part).sum())
        return int(complete.argmax()) if complete.any() else len(covered) - 1
    log = state.discovery_log[episode, agent, : state.known[episode, agent]]
    row, col = state.cell[episode, agent]
    own = np.flatnonzero(parts.flat[log] == parts[row, col])
    if len(own) < int((parts == parts[row, col]).sum()):
        return len(covered) - 1
    counted = int(state.counts[episode].flat[log[: own[-1] + 1]].sum())
    return int(np.searchsorted(covered, counted))


def stood_still(cells: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Return (S, N) which steps left N UAVs in their (S + 1, N, 2) ``cells``, blocked moves included."""
    return np.asarray(~np.diff(cells, axis=0).any(axis=2))


def to_and_fro(cells: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Return (S, N) which steps undid the move of the step before, given (S + 1, N, 2) ``cells``."""
    moves = np.diff(cells, axis=0)
    back = np.zeros(moves.shape[:2], np.bool_)
    back[1:] = (moves[1:] == -moves[:-1]).all(axis=2) & moves[1:].any(axis=2)
    return back


def longest_run(flags: NDArray[np.bool_]) -> int:
    """Return the most True in a row in any column of (S, N) ``flags``."""
    columns = np.pad(flags, ((1, 1), (0, 0))).T.ravel()
    edges = np.flatnonzero(columns[1:] != columns[:-1])
    return int((edges[1::2] - edges[::2]).max(initial=0))
