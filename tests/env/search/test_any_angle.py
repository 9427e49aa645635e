"""Tracks with straight lines for staircases, against hand-made cases and an exact search."""

from math import hypot, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.search.any_angle import straightened_length
from tests.env.worlds import begun, floorplans, random_actions, scenarios

ROOM = np.full((12, 12), FREE, np.uint8)


def track(moves: str, start=(5, 5)) -> np.ndarray:
    """The cells of moves such as ``RRD``; a dot stays."""
    steps = {"U": (-1, 0), "D": (1, 0), "L": (0, -1), "R": (0, 1), ".": (0, 0)}
    return np.cumsum([start, *(steps[move] for move in moves)], axis=0)


@pytest.mark.parametrize(
    ("moves", "length"),
    [
        ("", 0.0),
        ("...", 0.0),
        ("RRR", 3.0),
        ("RDRDRD", 3 * sqrt(2)),
        ("RR.DD", sqrt(8)),
        ("RRLL", 4.0),
        ("RDRDLULU", 4 * sqrt(2)),
        ("RRDDLLUU", 2 * sqrt(8)),
        ("RRRRUULLLL", hypot(4, 2) + 4),
    ],
)
def test_staircases_are_straight_and_ways_back_are_not_left_out(moves, length):
    assert straightened_length(ROOM, track(moves)) == pytest.approx(length)


def test_no_line_passes_an_obstacle():
    walled = ROOM.copy()
    walled[6, 6] = OCCUPIED
    assert straightened_length(walled, track("RRDD")) == pytest.approx(4.0)
    assert straightened_length(walled, track("RRRDD")) == pytest.approx(sqrt(10) + 1)


@settings(max_examples=50, deadline=None)
@given(scenarios(most=1, on_collision="block"), floorplans(), st.integers(0, 2**32))
def test_a_straightened_track_is_between_its_displacement_and_its_cells(scenario, floorplan, seed):
    world, rng = begun(scenario, floorplan, seed), np.random.default_rng(seed)
    cells = [world.state.cell[0, 0].copy()]
    for _ in range(30):
        world.step(random_actions(rng, world))
        cells.append(world.state.cell[0, 0].copy())
    flown, (down, right) = np.array(cells), cells[-1] - cells[0]
    moves = np.abs(np.diff(flown, axis=0)).sum()
    length = straightened_length(floorplan.truth, flown)
    assert max(hypot(down, right), moves / sqrt(2)) - 1e-9 <= length <= moves + 1e-9
