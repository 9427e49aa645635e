from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import World, scenario
from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN
from indoor_explorers.env.sensing.lidar import scan, view_gain
from indoor_explorers.planners.toolbox.information.candidates import UnknownWeight
from indoor_explorers.planners.toolbox.information.pose_views import (
    HEADINGS,
    camera,
    heading_gains,
    pose_views,
    shows_new,
    unknown_weights,
)

PLAIN = UnknownWeight(0.0, 1e9)


def sector(belief: Belief, cell: tuple[int, int], heading: int, reach: float, degrees: float) -> Mask:
    """The unknown cells that the world's scan would show if they were free, angle by angle, (H, W) bool."""
    open_map = np.where(belief == OCCUPIED, OCCUPIED, FREE).astype(np.uint8)
    rows, cols = np.indices(belief.shape) - np.reshape(cell, (2, 1, 1))
    faced = np.arctan2(MOVES[heading, 1], MOVES[heading, 0])
    angle = np.abs((np.arctan2(cols, rows) - faced + np.pi) % (2 * np.pi) - np.pi)
    ahead = (angle <= np.radians(degrees / 2) + 1e-6) | (np.maximum(abs(rows), abs(cols)) <= 1)
    return np.asarray(ahead & (scan(open_map, cell, reach) != UNKNOWN) & (belief == UNKNOWN))


def free_cells(belief: Belief) -> list[tuple[int, int]]:
    return [(row, col) for row, col in np.argwhere(belief == FREE).tolist()][:12]


@pytest.mark.parametrize("degrees", [60.0, 90.0, 120.0])
def test_gains_of_poses_are_what_the_lidar_would_show_there(belief: Belief, degrees: float) -> None:
    cells = free_cells(belief)
    flat = np.array([row * belief.shape[1] + col for row, col in cells], np.int32)
    gains = heading_gains(belief, flat, unknown_weights(belief, PLAIN), camera(4.0, degrees))
    for cell, row in zip(cells, gains, strict=True):
        expected = [sector(belief, cell, heading, 4.0, degrees).sum() for heading in range(HEADINGS)]
        assert row == pytest.approx(expected, abs=1e-6)
        news = [shows_new(belief, cell, heading, camera(4.0, degrees)) for heading in range(HEADINGS)]
        assert news == [count > 0 for count in expected]


def test_shared_views_of_poses_are_the_overlaps_of_sectors(belief: Belief) -> None:
    poses = [(cell, heading) for cell in free_cells(belief)[:4] for heading in range(HEADINGS)]
    flat = np.array([row * belief.shape[1] + col for (row, col), _ in poses], np.int32)
    headings = np.array([heading for _, heading in poses])
    gains, shared = pose_views(belief, flat, headings, unknown_weights(belief, PLAIN), camera(4.0, 90.0))
    seen = [sector(belief, cell, heading, 4.0, 90.0) for cell, heading in poses]
    assert gains == pytest.approx([each.sum() for each in seen], abs=1e-6)
    both = np.array([[(a & b).sum() / max(a.sum(), 1) for b in seen] for a in seen])
    assert shared == pytest.approx(both, abs=1e-6)


def test_all_around_every_heading_shows_the_same(belief: Belief) -> None:
    cells = free_cells(belief)
    flat = np.array([row * belief.shape[1] + col for row, col in cells], np.int32)
    gains = heading_gains(belief, flat, unknown_weights(belief, PLAIN), camera(4.0, 360.0))
    assert gains == pytest.approx(np.array([[view_gain(belief, cell, 4.0)] * HEADINGS for cell in cells]), abs=1e-6)


def test_a_turn_in_an_open_room_shows_the_gain_that_was_expected() -> None:
    world = World(scenario("thesis-open").with_settings({"lidar.field_of_view": 90.0, "on_collision": "block"}))
    world.reset(seeds=[4])
    for action in (5, 0, 5, 3, 5, 5):
        view = world.view(0, 0)
        row, col = view.cell
        to = view.cell if action == 5 else (row + int(MOVES[action, 0]), col + int(MOVES[action, 1]))
        heading = (int(view.heading or 0) + 1) % 4 if action == 5 else action
        if view.belief[to] != FREE:
            continue
        inside = sector(view.belief, to, heading, 3.0, 90.0)
        flat = np.array([to[0] * view.belief.shape[1] + to[1]], np.int32)
        values = (view.belief.ravel() == UNKNOWN).astype(np.float64)
        expected = heading_gains(view.belief, flat, values, camera(3.0, 90.0))[0, heading]
        before = view.belief.copy()
        world.step([[action]])
        found = (world.view(0, 0).belief != UNKNOWN) & (before == UNKNOWN)
        assert found.sum() <= expected == inside.sum()  # walls at the edge hide what is behind them
        assert not (found & ~inside).any()
