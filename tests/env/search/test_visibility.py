"""VisibilityTable: what every cell shows is what its scan shows, counted right."""

import numpy as np
import pytest

from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.search.bitsets import bit_count
from indoor_explorers.env.search.visibility import add_visible, count_cells, count_unseen, visibility_table
from indoor_explorers.env.sensing.lidar import lidar_model, scan


def noise(seed):
    rng = np.random.default_rng(seed)
    truth = np.where(rng.random((int(rng.integers(1, 30)), int(rng.integers(9, 30)))) < 0.3, 2, 1).astype(np.uint8)
    free = np.argwhere(Floorplan(truth, "noise").main_part)
    return truth, [tuple(cell) for cell in free[rng.permutation(len(free))[:2]].tolist()]


@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize(("reach", "model"), [(2.0, "exact"), (9.5, "exact"), (4.0, "marsexplorer")])
@pytest.mark.parametrize("seed", range(3))
def test_views_along_a_way_add_up_as_scans_do(seed, reach, model, whole):
    truth, starts = noise(seed)
    table = visibility_table(truth, starts, lidar_model(reach, model), count_all_cells=whole)
    reachable = np.isin(np.arange(truth.size), table.cells).reshape(truth.shape)
    seen, union = np.zeros_like(table.union), np.zeros(truth.shape, np.bool_)
    for number in np.random.default_rng(seed).permutation(len(table.cells))[:20].tolist():
        shown = scan(truth, divmod(int(table.cells[number]), truth.shape[1]), reach, model) > 0
        new = shown & ~union if whole else shown & ~union & reachable
        assert count_unseen(table, number, seen) == add_visible(table, number, seen) == new.sum()
        union |= new
        assert count_cells(seen) == union.sum()


@pytest.mark.parametrize("seed", range(3))
def test_cells_are_numbered_by_their_distance_from_the_starts(seed):
    truth, starts = noise(seed)
    table = visibility_table(truth, starts, lidar_model(2.0), count_all_cells=False)
    steps = np.minimum(*(distance_field(truth, start) for start in starts)).ravel()[table.cells]
    assert [divmod(int(cell), truth.shape[1]) for cell in table.cells[:2]] == starts
    assert (np.diff(steps) >= 0).all()
    assert steps.max() < 2**30
    assert count_cells(table.union) == len(table.cells)


def test_bits_are_counted():
    for word in (0, 1, 2**63, 2**64 - 1, 0xF0F0123456789ABC):
        assert int(bit_count(np.uint64(word))) == word.bit_count()
