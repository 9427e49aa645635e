"""The fewest steps there are, against a search of all walks."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import PRESETS, World
from indoor_explorers.env.search.visibility import VisibilityTable, add_visible, visibility_table
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.planners.reference import watchman
from indoor_explorers.planners.reference.watchman import Solution, Watch, fewest_steps, steps_to
from tests.env.search.small_maps import connected_map
from tests.evaluation.harness.episodes.test_lower_bounds import SHARES
from tests.evaluation.harness.episodes.test_lower_bounds import fewest_steps as all_walks
from tests.marks import slow

MOST = 10**6


def solved(truth, starts, reach, share, below=60, most=MOST) -> tuple[VisibilityTable, Solution]:
    table = visibility_table(truth, starts, lidar_model(reach), count_all_cells=False)
    needed = math.ceil(share * len(table.cells) - 1e-9)
    return table, fewest_steps(Watch(table, len(starts), np.zeros_like(table.union), needed), below, most)


def assert_walked(table, found, share):
    """The walks go from cell to neighbouring cell from the starts, and show enough in just so many steps."""
    assert steps_to(table, found.walks, math.ceil(share * len(table.cells) - 1e-9)) == found.lower
    assert [walk[0] for walk in found.walks] == list(range(len(found.walks)))
    assert max(map(len, found.walks)) == found.lower + 1
    for walk in found.walks:
        assert all(b in table.neighbours[a] for a, b in pairwise(walk))


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), rows=st.integers(2, 5), columns=st.integers(3, 5), reach=st.sampled_from([1.0, 2.0]))
def test_one_uav_takes_the_fewest_steps_there_are(seed, rows, columns, reach):
    truth, cells = connected_map(seed, (rows, columns), 0.3)
    best = all_walks(truth, cells[:1], reach, SHARES)
    for share in SHARES:
        table, found = solved(truth, cells[:1], reach, share)
        assert found.lower == best[share]
        assert_walked(table, found, share)


@pytest.mark.parametrize("seed", range(8))
def test_two_uavs_take_the_fewest_steps_there_are(seed):
    truth, cells = connected_map(seed, (4, 4), 0.3)
    best = all_walks(truth, cells[:2], 1.0, SHARES)
    for share in SHARES:
        table, found = solved(truth, cells[:2], 1.0, share)
        assert found.lower == best[share]
        assert_walked(table, found, share)


@pytest.mark.parametrize(("length", "start", "reach"), [(30, 7, 2), (30, 20, 3), (9, 4, 1), (20, 0, 3)])
def test_corridors_have_a_formula(length, start, reach):
    left, right = max(0, start - reach), max(0, length - 1 - start - reach)
    _, found = solved(np.ones((1, length), np.uint8), [(0, start)], float(reach), 1.0, below=100)
    assert found.lower == min(2 * left + right, left + 2 * right)


def room(scenario, seed):
    world = World(PRESETS[scenario].for_evaluation())
    world.begin(0, seed)
    return world.state.truth[0], [tuple(cell) for cell in world.state.cell[0].tolist()]


@pytest.mark.parametrize(
    ("scenario", "seed", "share", "expected"),
    [
        ("thesis-open", 0, 0.99, 42),
        ("thesis-open", 0, 1.0, 44),
        ("thesis-obstacles", 2, 0.99, 55),
        ("thesis-obstacles", 2, 0.9, 38),
        ("thesis-team-2", 1, 0.99, 23),
    ],
)
def test_rooms_of_the_thesis(scenario, seed, share, expected):
    table, found = solved(*room(scenario, seed), 3.0, share)
    assert found.lower == expected
    assert_walked(table, found, share)


def test_a_number_of_steps_that_suffices_is_the_answer_where_none_fewer_do():
    truth, starts = room("thesis-obstacles", 2)
    _, found = solved(truth, starts, 3.0, 0.99, below=55)
    assert (found.lower, found.walks) == (55, None)


@pytest.mark.parametrize("most", [0, *slow(1), 30])
def test_a_search_that_does_not_end_has_proved_a_bound(most):
    _, found = solved(*room("thesis-open", 3), 3.0, 0.99, below=50, most=most)
    assert 40 <= found.lower <= 44
    assert found.walks is None
    assert found.expanded <= most


def test_hard_rooms_are_searched_with_a_longer_memory(monkeypatch):
    truth, starts = room("thesis-open", 3)
    monkeypatch.setattr(watchman, "EASY", 50)
    table, found = solved(truth, starts, 3.0, 0.99)
    assert found.lower == 44
    assert_walked(table, found, 0.99)


def test_cells_that_are_known_need_not_be_seen():
    truth, starts = room("thesis-obstacles", 2)
    table = visibility_table(truth, starts, lidar_model(3.0), count_all_cells=False)
    known = np.zeros_like(table.union)
    for cell in range(1, len(table.cells)):
        add_visible(table, cell, known)
    assert fewest_steps(Watch(table, 1, known, len(table.cells)), 60, MOST).lower == 0
