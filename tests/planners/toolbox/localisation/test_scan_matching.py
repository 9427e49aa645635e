"""Scans are matched with maps: readings are recovered, true offsets fit best, and slips are found where they were."""

import numpy as np
import pytest

from indoor_explorers.env.sensing.inverse_model import CERTAIN, HIT, PASS
from indoor_explorers.planners.toolbox.localisation.scan_matching import (
    OFFSETS,
    REACH,
    OffsetFilter,
    Scan,
    consistency,
    offset_scores,
    scan_between,
)

#: A room of 12 x 14 cells with two pillars, whose walls tell all offsets apart.
ROOM = np.pad(np.zeros((10, 12), bool), 1, constant_values=True)
ROOM[3, 4] = ROOM[7, 9] = True
MAP = np.where(ROOM, 4 * HIT, 4 * PASS).astype(np.float32)


def scan_at(row, col, reach=4):
    cells = [
        (r - row, c - col)
        for r, c in np.argwhere(np.ones(ROOM.shape, bool))
        if max(abs(r - row), abs(c - col)) <= reach
    ]
    values = [HIT if ROOM[row + r, col + c] else PASS for r, c in cells]
    return Scan(np.array(cells), np.array(values, np.float32))


def test_a_scan_is_recovered_from_two_maps_and_other_changes_are_ignored():
    before = np.zeros((9, 9), np.float32)
    after = before.copy()
    after[4, 4] += CERTAIN * PASS
    after[3, 4] += PASS
    after[2, 4] += HIT
    after[4, 6] += HIT + PASS  # two scans at once
    after[8, 8] += HIT  # out of reach
    scan = scan_between(before, after, (4, 4), 3)
    found = {tuple(cell): value for cell, value in zip(scan.cells.tolist(), scan.values.tolist(), strict=True)}
    assert found == {(0, 0): CERTAIN * PASS, (-1, 0): PASS, (-2, 0): HIT}


@pytest.mark.parametrize("offset", [(0, 0), (1, 0), (0, -1), (-1, 1)])
def test_the_true_offset_fits_best(offset):
    scores = offset_scores(MAP, scan_at(5 + offset[0], 6 + offset[1]), (5, 6))
    assert scores.shape == (OFFSETS, OFFSETS)
    assert scores[REACH + offset[0], REACH + offset[1]] == scores.max() == 0.0
    assert np.sort(scores.ravel())[-2] < -1.0


def test_what_is_unknown_says_nothing():
    assert not offset_scores(np.zeros_like(MAP), scan_at(5, 6), (5, 6)).any()


def test_the_filter_is_a_distribution_that_spreads_and_sharpens():
    chances = OffsetFilter()
    assert chances.doubt == 0.0
    chances.move(0.2)
    assert chances.doubt == pytest.approx(0.2)
    assert chances.chances[REACH, REACH - 1] == pytest.approx(0.05)
    chances.match(offset_scores(MAP, scan_at(5, 5), (5, 6)))
    assert chances.best == (0, -1)
    assert chances.doubt > 0.9
    assert chances.chances.sum() == pytest.approx(1.0)
    chances.recentre()
    assert chances.doubt == 0.0


def test_scans_fit_together_best_when_moved_from_the_slip_on():
    way, slip = [(5, col) for col in range(2, 11)], 4
    scans = [scan_at(row, col) for row, col in way]
    believed = [(row, col if n < slip else col - 1) for n, (row, col) in enumerate(way)]
    starts = np.cumsum([0, *(len(scan.values) for scan in scans)])
    cells = np.concatenate([scan.cells + cell for scan, cell in zip(scans, believed, strict=True)])
    values = np.concatenate([scan.values for scan in scans])
    fits = [
        consistency(cells, values, starts, first, np.array([0, 1]), np.zeros_like(MAP)) for first in range(1, len(way))
    ]
    assert 1 + int(np.argmax(fits)) == slip
