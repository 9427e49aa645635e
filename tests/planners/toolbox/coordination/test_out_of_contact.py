from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import Mate, World, scenario
from indoor_explorers.env.grid.arrays import Cell, Distances
from indoor_explorers.planners.toolbox.coordination.out_of_contact import LEAST, OutOfContact, Sectors
from indoor_explorers.planners.toolbox.navigation.teammates import MEMORY
from tests.planners.flights import view_of

#: The corners of an open room.
POINTS = np.array([[0.0, 0.0], [0.0, 15.0], [15.0, 0.0], [15.0, 15.0]])


def out_of_contact(team: int, agent: int = 0, radio: str = "disc") -> OutOfContact:
    world = World(scenario("thesis-open").with_settings({"team": team, "radio.model": radio, "radio.range": 2.0}))
    world.reset([0])
    return OutOfContact(world.briefing(0, agent), silence=1.0, sector=2.0)


def steps_from(cell: Cell) -> Distances:
    return np.asarray(np.abs(POINTS - cell).sum(axis=1), np.int32)


def factors(of: OutOfContact, cell: Cell, *mates: Mate) -> NDArray[np.float64]:
    found = of.factors(view_of(np.ones((16, 16), np.uint8), cell, mates), POINTS, steps_from(cell), steps_from)
    assert (found > 0.0).all()
    assert (found <= 1.0).all()
    return found


def test_whoever_is_alone_or_linked_to_all_has_nothing_to_leave() -> None:
    assert factors(out_of_contact(1), (8, 8)).tolist() == [1.0] * 4
    assert factors(out_of_contact(2), (8, 8), Mate(1, (8, 9), 0, (0.0, 0.0))).tolist() == [1.0] * 4


def test_a_silent_one_keeps_what_it_is_nearer_to_and_a_forgotten_one_nothing() -> None:
    silent = factors(out_of_contact(2), (15, 15), Mate(1, (0, 2), 10, None))
    assert silent == pytest.approx([LEAST, np.exp(-2.0 / 3.0), 1.0, 1.0])
    assert factors(out_of_contact(2), (15, 15), Mate(1, (0, 2), MEMORY + 1, None)).tolist() == [1.0] * 4


def test_those_never_heard_count_the_less_the_fewer_they_are() -> None:
    all_unheard = factors(out_of_contact(4, radio="none"), (8, 8))
    linked = Mate(1, (8, 9), 0, None)
    one_heard = factors(out_of_contact(4), (8, 8), linked)
    assert one_heard == pytest.approx(all_unheard ** (2 / 3))
    assert all_unheard.min() < 0.1


def test_uavs_that_never_heard_of_each_other_prefer_different_places() -> None:
    best = {int(factors(out_of_contact(4, agent, "none"), (8, 8)).argmax()) for agent in range(4)}
    assert len(best) == 4


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
