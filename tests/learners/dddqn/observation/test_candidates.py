"""Candidate features of the moves against their definition."""

import math

import numpy as np
import pytest

from indoor_explorers.env import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.env.sensing.lidar import lidar_model, new_scan, visible_cells
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import PROSPECT, PROSPECTS, observation_layout, tour_costs
from tests.learners.dddqn.observation.test_observe import Watcher
from tests.learners.dddqn.rooms import random_belief

SIGHT = ObservationConfig(
    layers=("unknown",), coarse=0, sides=False, gains=False, visits=False, tours=False, prospects=True
)
THERE, BEHIND, BEST, WAY, VIEW = range(len(PROSPECT))


def looked(
    belief: Belief, cell: Cell, lidar: float = 3.0, mates: list[Cell] | None = None, ages: tuple[int, ...] = (-1, -1)
) -> Watcher:
    watcher = Watcher(SIGHT, belief.shape, lidar)
    watcher.look(belief, cell, mates, ages)
    return watcher


def features(watcher: Watcher) -> np.ndarray:
    """(2, 4, 5) for each kind and move."""
    return watcher.moves[0, :, 1:].reshape(4, len(PROSPECTS), len(PROSPECT)).swapaxes(0, 1)


def views(belief: Belief, cell: Cell, lidar: float) -> tuple[int, float]:
    """Unknown cells in view, and their number with isolated ones counting up to nine times."""
    lens = lidar_model(lidar)
    scan, padded = new_scan(lens), np.pad(belief, 2, constant_values=OCCUPIED)
    cells = {divmod(int(k), belief.shape[1]) for k in scan.cells[: visible_cells(belief, *cell, lens, scan)]}
    unknown = [(r, c) for r, c in cells if belief[r, c] == UNKNOWN]
    known = [(padded[r : r + 5, c : c + 5] != UNKNOWN).sum() for r, c in unknown]
    return len(unknown), float(sum(1 + 8 * count / 24 for count in known))


@pytest.mark.parametrize("lidar", [2.0, 3.0, 5.5])
def test_prospects_are_what_their_definition_says(lidar):
    rng, compared = np.random.default_rng(4), 0
    for _ in range(10):
        belief, cell = random_belief(rng)
        shown = features(looked(belief, cell, lidar))
        offered = frontier_mask(belief) & (distance_field(belief, cell) < 1000)
        offered[cell] = False
        places = [(int(r), int(c)) for r, c in np.argwhere(offered)]
        sights = {place: views(belief, place, lidar) for place in places}
        for kind, (power, rate) in enumerate([(1.0, 1.5), (0.5, 0.8)]):
            worth = np.zeros(4)
            for k, (dr, dc) in enumerate(MOVES[:4].tolist()):
                r, c = cell[0] + dr, cell[1] + dc
                if not (0 <= r < belief.shape[0] and 0 <= c < belief.shape[1]) or belief[r, c] != FREE:
                    continue
                steps = distance_field(belief, (r, c))
                for place in places:
                    worth[k] = max(worth[k], sights[place][kind] ** power * math.exp(-rate * steps[place] / lidar))
            for k in range(4):
                if worth[k] == 0.0:
                    assert shown[kind, k].tolist() == [0, float(worth.any()), 0, 0, 0]
                    continue
                behind = 3.0 * math.log(worth.max() / worth[k]) / rate
                assert shown[kind, k, THERE] == 1
                assert shown[kind, k, BEHIND] == pytest.approx(min(behind / 8, 1), abs=1e-5)
                assert shown[kind, k, BEST] == (behind < 1e-9)
                compared += 1
    assert compared > 40


def test_a_step_away_costs_two_and_distance_and_view_are_told():
    belief = np.full((3, 20), OCCUPIED, np.uint8)
    belief[1, 1:16] = FREE
    belief[1, 16:19] = UNKNOWN
    shown = features(looked(belief, (1, 8), 3.0))
    down, left, up, right = range(4)
    for kind in range(2):
        assert shown[kind, right].tolist() == pytest.approx([1, 0, 1, 6 / 14, math.sqrt(3 / 28)], abs=1e-6)
        assert shown[kind, left, BEHIND] == pytest.approx(2 / 8)
        assert shown[kind, left, WAY] == pytest.approx(8 / 16)
        assert shown[kind, down].tolist() == shown[kind, up].tolist() == [0, 1, 0, 0, 0]


def corridor() -> Belief:
    """Unknown at both ends, a little farther away on the right."""
    belief = np.full((3, 21), OCCUPIED, np.uint8)
    belief[1, 3:18] = FREE
    belief[1, 1:3] = belief[1, 18:20] = UNKNOWN
    return belief


def test_cells_closer_to_a_teammate_are_left_to_it():
    best = [int(features(looked(corridor(), (1, 9)))[kind, :, BEST].argmax()) for kind in range(2)]
    assert best == [1, 1]
    left = {"mates": [(1, 5), (0, 0)], "ages": (2, -1)}
    assert features(looked(corridor(), (1, 9), **left))[:, 3, BEST].tolist() == [1, 1]
    long_ago = left | {"ages": (10, -1)}
    assert features(looked(corridor(), (1, 9), **long_ago))[:, 1, BEST].tolist() == [1, 1]


def test_the_last_best_candidate_is_preferred():
    belief = corridor()
    fresh = looked(belief, (1, 10))
    assert features(fresh)[:, :, BEST].sum(axis=1).tolist() == [2, 2]
    held = looked(belief, (1, 11))
    assert features(held)[:, 3, BEST].tolist() == [1, 1]
    held.look(belief, (1, 10))
    assert features(held)[:, 3, BEST].tolist() == [1, 1]
    assert features(held)[:, 1, BEST].tolist() == [0, 0]


def test_a_teammate_in_the_way_blocks_the_candidates_behind_it():
    watcher = looked(corridor(), (1, 9))
    watcher.memory.aimed[:] = 21 + 8
    watcher.look(corridor(), (1, 9))
    assert features(watcher)[:, 3, BEST].tolist() == [1, 1]
    assert features(watcher)[:, 1, THERE].tolist() == [0, 0]


def test_steps_behind_the_best_by_all_that_is_in_view_cost_and_pull():
    layout = observation_layout(SIGHT)
    costs = tour_costs(layout, 0.1, 0.3)
    assert costs is not None
    assert np.flatnonzero(costs).tolist() == [layout.prospects_at + BEHIND]
    assert costs[costs != 0].tolist() == pytest.approx([-0.8])
    assert tour_costs(layout, 0.0, 0.0) is None


def test_steps_behind_the_best_of_both_kinds_cost_half_each():
    layout = observation_layout(SIGHT)
    costs = tour_costs(layout, 0.1, 0.3, kinds=NetworkConfig(candidates="both").kinds)
    assert costs is not None
    places = [layout.prospects_at + BEHIND, layout.prospects_at + len(PROSPECT) + BEHIND]
    assert np.flatnonzero(costs).tolist() == places
    assert costs[places].tolist() == pytest.approx([-0.4, -0.4])
