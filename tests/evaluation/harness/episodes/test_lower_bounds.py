"""No team beats the lower bound, not even one that knows the map."""

from collections import deque
from itertools import product

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World, make_policy
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.search.visibility import visibility_table
from indoor_explorers.env.sensing.lidar import lidar_model, scan
from indoor_explorers.evaluation.harness.episodes import lower_bounds
from indoor_explorers.evaluation.harness.episodes.lower_bounds import least_steps
from indoor_explorers.evaluation.harness.episodes.metrics import first_step
from indoor_explorers.evaluation.harness.episodes.mst_bound import _between, _longest_tree, spanning_tree_bound
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from tests.env.search.small_maps import connected_map

MOVES = ((1, 0), (0, -1), (-1, 0), (0, 1))
SHARES = (0.5, 0.9, 0.99, 1.0)


def fewest_steps(truth, starts, reach, shares, model="exact"):
    """Search all ways of a team breadth-first: the fewest steps to each share of the free cells.

    UAVs may share a cell here, which can only be quicker.
    """
    total = int((truth == 1).sum())

    def seen(cell):
        return frozenset(np.flatnonzero(scan(truth, cell, reach, model) == 1).tolist())

    def onward(cell):
        around = [(cell[0] + row, cell[1] + column) for row, column in MOVES]
        inside = [(r, c) for r, c in around if 0 <= r < truth.shape[0] and 0 <= c < truth.shape[1]]
        return [cell, *(there for there in inside if truth[there] == 1)]

    shows = {cell: seen(cell) for cell in map(tuple, np.argwhere(truth == 1).tolist())}
    first = (tuple(sorted(starts)), frozenset().union(*(shows[cell] for cell in starts)))
    queue, known, found = deque([(first, 0)]), {first}, {}
    while queue:
        (cells, covered), steps = queue.popleft()
        for share in shares:
            if share not in found and len(covered) >= share * total - 1e-9:
                found[share] = steps
        if len(found) == len(shares):
            return found
        for there in product(*map(onward, cells)):
            state = (tuple(sorted(there)), covered.union(*(shows[cell] for cell in there)))
            if state not in known:
                known.add(state)
                queue.append((state, steps + 1))
    raise AssertionError("the map is not connected")


def begun(truth, starts, reach, model="exact"):
    settings = {"lidar.range": reach, "lidar.model": model, "team": len(starts)}
    world = World(PRESETS["thesis-open"].for_evaluation().with_settings(settings))
    world.begin(0, 0, floorplan=Floorplan(truth, "small"), spawns=starts)
    return world


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize(("reach", "model"), [(1.0, "exact"), (2.0, "exact"), (1.5, "marsexplorer")])
def test_the_best_way_there_is_takes_no_less(seed, reach, model):
    truth, cells = connected_map(seed, (5, 5), 0.35)
    best = fewest_steps(truth, cells[:1], reach, SHARES, model)
    world = begun(truth, cells[:1], reach, model)
    for share in SHARES:
        assert least_steps(world, 0, share) <= best[share]


@pytest.mark.parametrize("seed", range(6))
def test_the_best_ways_of_two_take_no_less(seed):
    truth, cells = connected_map(seed, (4, 4), 0.3)
    best = fewest_steps(truth, cells[:2], 1.0, SHARES)
    world = begun(truth, cells[:2], 1.0)
    for share in SHARES:
        assert least_steps(world, 0, share) <= best[share]


def test_the_bound_is_met_in_corridors_and_stars():
    corridor = np.ones((1, 12), np.uint8)
    for share in SHARES:
        best = fewest_steps(corridor, [(0, 0)], 2.0, [share])[share]
        assert least_steps(begun(corridor, [(0, 0)], 2.0), 0, share) == best
    cross = np.full((9, 9), 2, np.uint8)
    cross[4] = cross[:, 4] = 1
    assert least_steps(begun(cross, [(4, 4), (4, 5)], 1.0), 0, 1.0) >= 6
    assert least_steps(begun(cross, [(4, 4)], 1.0), 0, 1.0) >= 12


@pytest.mark.parametrize("policy", ["reference", "frontier-nearest", "frontier-minpos", "random"])
@pytest.mark.parametrize("scenario", ["thesis-obstacles", "thesis-team-4"])
def test_nobody_flies_below_the_bound(policy, scenario):
    task = PRESETS[scenario].for_evaluation()
    world = World(task)
    for record in fly(make_policy(policy), policy, task, [Task(scenario, 0, seed) for seed in range(5)]):
        world.begin(0, record.task.seed)
        for share in SHARES:
            reached = first_step(record.coverage("team"), share)
            assert reached is None or reached >= least_steps(world, 0, share) > 0


def test_an_open_hall_is_worked_out_by_hand(monkeypatch):
    monkeypatch.setattr(lower_bounds, "flow_bound", lambda *_: 0)
    world = begun(np.ones((16, 16), np.uint8), [(8, 8)], 3.0)
    assert least_steps(world, 0, 0.9) == -(-(231 - 29) // 7) == 29
    assert least_steps(world, 0, 0.05) == 0


def test_where_looking_would_take_too_long_range_alone_counts(monkeypatch):
    world = begun(np.ones((16, 16), np.uint8), [(8, 8)], 3.0)
    full = least_steps(world, 0, 1.0)
    monkeypatch.setattr(lower_bounds, "EFFORT", 0)
    assert 0 < least_steps(world, 0, 1.0) <= full


@pytest.mark.parametrize("largest", [1, 4, 80])
def test_spanning_trees_are_those_of_networkx(largest):
    rng = np.random.default_rng(largest)
    for count in (1, 2, 3, 9, 32):
        upper = np.triu(rng.integers(0, largest + 1, (count, count)), 1)
        between = upper + upper.T
        assert _longest_tree(between) == longest_tree(between)


def longest_tree(between):
    """The length of the longest minimum spanning tree of the first 2, 3, ... groups."""
    graph = nx.from_numpy_array(between + 1)  # an edge of no length would be none
    trees = (nx.minimum_spanning_tree(graph.subgraph(range(count))) for count in range(2, len(between) + 1))
    return max((tree.size("weight") - (len(tree) - 1) for tree in trees), default=0)


@pytest.mark.parametrize("seed", range(4))
def test_regions_and_their_tree_are_those_of_plain_searches(seed):
    truth, cells = connected_map(seed, (14, 17), 0.35)
    table = visibility_table(truth, cells[:1], lidar_model(3.0), count_all_cells=False)
    between = _between(table, 17, 1, 1, 5)
    assert _longest_tree(between) == longest_tree(between)
    field = distance_field(truth, cells[0])
    entered = [field[scan(truth, cell, 3.0) == 1].min() for cell in cells]
    assert between[0, 1] == max(entered)
    assert spanning_tree_bound(table, 17, 1, len(cells)) == 0


def test_a_task_is_bounded_once_for_all_policies(monkeypatch):
    worked = []

    def noted(world, episode, share):
        worked.append(share)
        return {"noted": 7 + len(worked)}

    monkeypatch.setattr(lower_bounds, "lower_bounds", noted)
    truth = np.ones((3, 17), np.uint8)
    assert [least_steps(begun(truth, [(0, 0)], 2.0), 0, share) for share in (0.77, 0.77, 0.78)] == [8, 8, 9]
    assert least_steps(begun(truth, [(0, 1)], 2.0), 0, 0.77) == 10
    assert least_steps(begun(truth, [(0, 0)], 3.0), 0, 0.77) == 11
    assert worked == [0.77, 0.78, 0.77, 0.77]
