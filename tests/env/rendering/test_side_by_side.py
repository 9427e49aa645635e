"""Flights side by side: each map whole, what is solid around left out, and coverage that grows."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World
from indoor_explorers.env.maps import Floorplan
from indoor_explorers.env.rendering import scene_of
from indoor_explorers.env.rendering.palette import BAR
from indoor_explorers.env.rendering.side_by_side import MOST, SideBySide, paint_side_by_side


def moment(solid: int, coverage: list[float], name: str = "a policy") -> SideBySide:
    free = np.zeros((10 + 2 * solid, 16 + 2 * solid), np.bool_)
    free[1 + solid : -1 - solid, 1 + solid : -1 - solid] = True
    world = World(PRESETS["thesis-team-2"])
    world.begin(
        0, 1, floorplan=Floorplan.from_free(free, "test"), spawns=[(2 + solid, 2 + solid), (5 + solid, 9 + solid)]
    )
    return SideBySide(name, scene_of(world, 0), coverage)


@pytest.mark.parametrize("count", range(1, MOST + 1))
def test_any_number_fits_a_picture_that_is_no_strip(count: int) -> None:
    picture = paint_side_by_side([moment(0, [0.1])] * count, 10)
    height, width = picture.shape[:2]
    assert 0.3 < width / height < 3.0 or count <= 2


def test_what_is_solid_around_is_left_out() -> None:
    plain, framed = (paint_side_by_side([moment(solid, [0.1, 0.2])], 10) for solid in (0, 7))
    assert np.array_equal(plain, framed)


def test_the_chart_reaches_as_far_as_was_flown() -> None:
    def painted(coverage: list[float]) -> int:
        picture = paint_side_by_side([moment(0, coverage)], 40)
        return int(np.flatnonzero((picture == BAR).all(axis=2).any(axis=0)).max())

    ends = [painted([0.02 * k for k in range(steps + 1)]) for steps in (10, 20, 40)]
    assert ends[0] < ends[1] < ends[2]
    assert ends[2] - ends[1] == pytest.approx(2 * (ends[1] - ends[0]), abs=3)
