"""Where the levels of a map are in its picture."""

import numpy as np
import pytest

from indoor_explorers.env.grid.levels import Levels, plane_of
from indoor_explorers.env.rendering.level_grid import LevelGrid

SIZES = [(7, 24, 24), (2, 5, 9), (3, 30, 4), (5, 1, 1)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("most", [np.inf, 60, 1])
def test_every_cell_has_a_place_of_its_own_within_the_picture(size, most):
    grid = LevelGrid.of(Levels(*size), most)
    plane = plane_of(np.arange(np.prod(size)).reshape(size), -1)
    picture, cells = grid.laid_out(plane, -2), np.argwhere(plane >= 0)
    assert picture.shape == grid.shape
    assert (picture[tuple(grid.places(cells).T)] == plane[tuple(cells.T)]).all()
    assert (picture != -1).all()
    assert np.count_nonzero(picture >= 0) == np.prod(size)
    assert grid.shape[1] <= most or grid.columns == 1


def test_levels_follow_each_other_row_by_row_below_their_names():
    grid = LevelGrid.of(Levels(7, 24, 24))
    assert (grid.columns, grid.gap, grid.shape) == (3, 3, (81, 78))
    assert [grid.corner(level) for level in range(4)] == [(3, 0), (3, 27), (3, 54), (30, 0)]
    assert grid.places(np.array([[0, 0], [24 + 1, 5], [3 * 25 + 2, 4]])).tolist() == [[3, 0], [3, 32], [32, 4]]


def test_a_map_of_one_level_is_its_own_picture():
    grid, plane = LevelGrid.of(Levels(1, 6, 8)), np.arange(48).reshape(6, 8)
    cells = np.array([[0, 0], [5, 7], [-1, 3], [6, 2]])
    assert grid.shape == (6, 8)
    assert grid.laid_out(plane, -1) is plane
    assert (grid.places(cells) == cells).all()


def test_voxels_of_many_cells_are_those_of_each():
    levels = Levels(3, 4, 5)
    cells = np.argwhere(~levels.between)
    assert [tuple(voxel) for voxel in levels.voxels(cells).tolist()] == [levels.voxel(tuple(cell)) for cell in cells]
    assert levels.voxels(cells[7]).tolist() == list(levels.voxel(tuple(cells[7])))
    assert (levels.size, Levels(1, 4, 5).size) == ((3, 4, 5), (4, 5))
