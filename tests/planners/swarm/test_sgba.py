from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from tests.planners.flights import fly, maze


@pytest.mark.parametrize(("agent", "moves"), [(0, {2}), (1, {3}), (2, {0}), (3, {1})])
def test_each_uav_sets_out_on_its_own_bearing(agent: int, moves: set[int]) -> None:
    middle = [(19, 20), (20, 21), (21, 20), (20, 19)]
    flight = fly(make_policy("sgba"), np.ones((41, 41), np.bool_), team=4, spawns=middle, budget=12, lidar=2.0)
    assert {row[agent] for row in flight.actions[:10]} == moves


def test_walls_are_followed_until_the_bearing_is_free_beyond() -> None:
    free = np.ones((15, 11), np.bool_)
    free[6, 3:8] = False
    flight = fly(make_policy("sgba"), free, spawns=[(10, 5)], budget=16, lidar=2.0)
    beyond = next(step for step, (row, _) in enumerate(flight.tracks[0]) if row < 6)
    assert beyond <= 9
    assert max(abs(col - 5) for _, col in flight.tracks[0][:beyond]) == 3


@pytest.mark.parametrize(("radio", "move"), [("none", 0), ("unlimited", 3)])
def test_the_later_of_two_that_are_near_turns_away(radio: str, move: int) -> None:
    free = np.ones((31, 41), np.bool_)
    flight = fly(make_policy("sgba"), free, team=2, radio=(radio, 0.0), spawns=[(9, 19), (9, 21)], budget=6)
    assert [row[1] for row in flight.actions[1:4]] == [move] * 3
    assert [row[0] for row in flight.actions[1:4]] == [2] * 3


def test_handing_over_is_told_and_can_be_switched_off() -> None:
    free = maze(6, 6, 3)
    flight = fly(make_policy("sgba"), free, lidar=1.0, budget=2000)
    assert flight.complete
    assert 0 < flight.pilots[0].tally()["finishing_steps"] < flight.steps
    alone = fly(make_policy("sgba", finish=False), free, lidar=1.0, budget=400)
    assert alone.pilots[0].tally()["finishing_steps"] == 0


def test_two_who_meet_in_a_corridor_do_not_stand_there_for_good() -> None:
    free = np.zeros((7, 24), np.bool_)
    free[3, 1:23] = free[1:3, 8] = free[4:6, 15] = True
    flight = fly(make_policy("sgba", finish=False), free, team=2, spawns=[(3, 10), (3, 13)], lidar=2.0, budget=400)
    assert flight.complete
    assert sum(pilot.tally()["held_up_steps"] for pilot in flight.pilots) > 0
