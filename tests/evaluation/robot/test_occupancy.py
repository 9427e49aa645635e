"""Occupancy grids on the cells of a planner."""

import math

import numpy as np
import pytest

from indoor_explorers.env import FREE, OCCUPIED, UNKNOWN, InputError
from indoor_explorers.evaluation.robot.occupancy import Area, belief_on, frame_on, occupancy_of
from tests.evaluation.robot.room import grid_of


def belief_from(message, cell, radius, area=None):
    grid = occupancy_of(message)
    frame = frame_on(area or grid.bounds(), cell)
    return frame, grid, belief_on(frame, grid, radius)


def belief_of(values, resolution, cell, radius, area=None, **origin):
    return belief_from(grid_of(values, resolution, **origin), cell, radius, area)


@pytest.mark.parametrize("yaw", [0.0, 0.3, math.pi / 2])
@pytest.mark.parametrize(("cell", "radius"), [(0.25, 0.22), (0.5, 0.1), (0.3, 0.4)])
def test_no_obstacle_is_near_a_free_cell_or_between_two(yaw, cell, radius):
    values = np.where(np.random.default_rng(1).random((60, 80)) < 0.02, 100, 0)
    frame, grid, belief = belief_of(values, 0.1, cell, radius, x=-2.03, y=1.01, yaw=yaw)
    blocks = np.argwhere(grid.values == 100)
    free = np.argwhere(belief == FREE)
    assert 20 < len(free) < belief.size
    cells = set(map(tuple, free.tolist()))
    apart = np.linspace(0.0, 1.0, 21)
    for row, col in free.tolist():
        x0, y0 = frame.point((row, col))
        u, v = grid.pixels(x0, y0)
        away = np.maximum(np.abs(np.array([v, u]) - blocks - 0.5) - 0.5, 0.0) * 0.1
        assert np.hypot(*away.T).min() >= radius - 1e-5
        for beside in ((row + 1, col), (row, col + 1)):
            if beside in cells:
                x1, y1 = frame.point(beside)
                assert (grid.values_at(x0 + apart * (x1 - x0), y0 + apart * (y1 - y0)) != 100).all()


def test_cells_of_the_size_of_pixels_are_the_pixels():
    values = np.array([[0, 100, -1], [0, 0, 40], [-1, 0, 10]])
    _, _, belief = belief_of(values, 1.0, 1.0, 0.3)
    assert belief[::-1].tolist() == [[FREE, OCCUPIED, UNKNOWN], [FREE, FREE, UNKNOWN], [UNKNOWN, FREE, FREE]]


def test_a_cell_is_free_where_half_of_it_is_known_to_be():
    values = np.zeros((4, 8), np.int8)
    values[:2, 4:] = values[0, :3] = -1  # half of the right cell, three pixels of the left one
    _, _, belief = belief_of(values, 0.25, 1.0, 0.1)
    assert belief.tolist() == [[FREE, FREE]]
    values[2, 7] = -1
    assert belief_of(values, 0.25, 1.0, 0.1)[2].tolist() == [[FREE, UNKNOWN]]


def test_a_turned_map_is_turned_back():
    values = np.zeros((2, 4), np.int8)
    values[0, 3] = 100
    _, _, belief = belief_of(values, 1.0, 1.0, 0.3, yaw=math.pi / 2)  # x runs up: four rows of two cells
    assert belief.shape == (4, 2)
    assert np.argwhere(belief == OCCUPIED).tolist() == [[0, 1]]


def test_an_area_leaves_the_rest_out_and_the_lattice_in_place():
    frame, _, belief = belief_of(np.zeros((40, 40)), 0.1, 0.25, 0.1, area=Area(0.9, 1.1, 2.1, 6.0), x=0.03)
    assert frame.origin == (0.75, 1.0)
    assert (belief[:8] == UNKNOWN).all()  # above the map
    assert (belief[-1] == FREE).all()


@pytest.mark.parametrize(
    ("grid", "cell", "said"),
    [
        (grid_of(np.zeros((3, 3)), 0.05, tilt=0.5), 0.25, "tilted"),
        (grid_of(np.zeros((3, 3)), 0.0), 0.25, "resolution above 0"),
        (grid_of(np.zeros((3, 3)), 0.5), 0.25, "--cell larger"),
        (grid_of(np.zeros((3, 3)), 1.0), 0.0005, "choose larger cells"),
    ],
)
def test_bad_maps_are_refused_in_a_line(grid, cell, said):
    with pytest.raises(InputError, match=said) as caught:
        belief_from(grid, cell, 0.2)
    assert "\n" not in str(caught.value)


def test_a_map_with_too_few_values_is_refused():
    grid = grid_of(np.zeros((3, 3)), 0.05)
    grid.data = grid.data[:-1]
    with pytest.raises(InputError, match="3 x 3 pixels, got 8"):
        occupancy_of(grid)
