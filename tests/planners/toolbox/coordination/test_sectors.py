from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import World, scenario
from indoor_explorers.planners.toolbox.coordination.sectors import Sectors


def every_cell(shape: tuple[int, int]) -> np.ndarray:
    return np.stack(np.divmod(np.arange(shape[0] * shape[1]), shape[1]), axis=1).astype(np.float64)


@pytest.mark.parametrize("centre", [(0.0, 0.0), (14.5, 30.0), (29.0, 3.0)])
@pytest.mark.parametrize("team", [2, 3, 8])
def test_sectors_hold_equally_many_cells(centre: tuple[float, float], team: int) -> None:
    shape = (30, 60)
    sectors = Sectors(shape, centre, team)
    shares = np.stack([sectors.shares(every_cell(shape), agent, 2.0) for agent in range(team)])
    assert (shares > 0.0).all()
    assert (shares <= 1.0).all()
    owned = np.bincount(shares.argmax(axis=0), minlength=team)
    assert owned == pytest.approx(np.full(team, 1800 / team), rel=0.08)


def test_without_strength_everything_is_everybodys() -> None:
    assert Sectors((9, 9), (4.0, 4.0), 3).shares(every_cell((9, 9)), 1, 0.0).tolist() == [1.0] * 81


def test_they_meet_at_the_start_of_a_team_and_else_in_the_middle() -> None:
    points = every_cell((16, 16))
    for spawn, centre in (("clustered", (3.0, 4.0)), ("random", (7.5, 7.5))):
        world = World(scenario("thesis-team-2").with_settings({"spawn": spawn}))
        world.reset([0])
        sectors = Sectors.of(world.briefing(0, 0), (3, 4))
        expected = Sectors((16, 16), centre, 2)
        assert sectors.shares(points, 1, 1.0).tolist() == expected.shares(points, 1, 1.0).tolist()
