"""Standing still and flying to and fro, by their definitions and in flights made for the purpose."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import Action, World, scenario
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.recorder import Log
from indoor_explorers.evaluation.harness.episodes.stalling import (
    behaviour_metrics,
    longest_run,
    searching_steps,
    stood_still,
    to_and_fro,
)

DOWN, LEFT, UP, RIGHT, STAY = (int(action) for action in Action)


def flown(rows, spawns, *plans, **settings):
    """Fly the ``plans``, an action a step for each UAV, over the map ``rows``; return the world and its log."""
    free = np.array([[character == "." for character in row] for row in rows])
    task = scenario("thesis-open").for_evaluation()
    task = task.with_settings({"team": len(plans), "lidar.range": 1.0, "on_collision": "block", **settings})
    world = World(task)
    world.begin(0, 0, floorplan=Floorplan.from_free(free, "test"), spawns=spawns)
    log = Log(world)
    for actions in zip(*plans, strict=True):
        world.step(np.array([actions]))
        log.add(np.array([actions]), np.zeros(1))
    return world, 0, log.steps(0), log.flown_steps[0]


def measured(*arguments, **settings):
    return behaviour_metrics(*flown(*arguments, **settings))


@pytest.mark.parametrize(
    ("columns", "run"),
    [(["", ""], 0), (["0000"], 0), (["1"], 1), (["1101110"], 3), (["0111", "1100"], 3), (["1", "1"], 1)],
)
def test_the_longest_run(columns, run):
    assert longest_run(np.array([[flag == "1" for flag in column] for column in columns], np.bool_).T) == run


def test_what_stands_still_and_what_takes_a_move_back():
    track = np.array([[0, 0], [0, 1], [0, 0], [0, 1], [0, 1], [0, 1], [0, 2], [0, 1]], np.int16)[:, None]
    assert stood_still(track)[:, 0].tolist() == [False, False, False, True, True, False, False]
    assert to_and_fro(track)[:, 0].tolist() == [False, True, True, False, False, False, True]
    assert to_and_fro(track[:1]).tolist() == []


def test_a_uav_that_freezes_and_dithers_on_its_way():
    plan = [STAY] * 3 + [RIGHT, LEFT] * 4 + [RIGHT, RIGHT] + [STAY] * 2
    found = measured(["........"], [(0, 0)], plan)
    assert found == {"longest_idle": 3, "longest_dither": 8, "idle_share": pytest.approx(5 / 15)}


def test_a_move_against_a_wall_or_a_teammate_is_standing_still():
    assert measured(["....#..."], [(0, 3)], [RIGHT] * 5)["longest_idle"] == 5
    plans = [RIGHT] * 4, [STAY] * 4
    assert measured([".........."], [(0, 4), (0, 5)], *plans)["idle_share"] == 1.0


def test_who_knows_all_it_can_reach_may_stand_still():
    plan = [RIGHT, RIGHT] + [STAY] * 9
    episode = flown(["....#.."], [(0, 0), (0, 5)], plan, [STAY] * 11)
    assert searching_steps(*episode) == [2, 0]
    assert behaviour_metrics(*episode) == {"longest_idle": 0, "longest_dither": 0, "idle_share": 0}


def test_what_a_teammate_tells_of_another_part_of_the_map_is_nothing_left_to_find():
    plans = [RIGHT, RIGHT] + [STAY] * 4, [RIGHT] * 4 + [STAY] * 2
    episode = flown(["....#......"], [(0, 0), (0, 5)], *plans, **{"radio.model": "unlimited"})
    assert searching_steps(*episode) == [2, 4]


def test_who_has_ended_wastes_no_steps():
    plans = [LEFT] + [STAY] * 7, [RIGHT] * 8
    episode = flown(["." * 20], [(0, 0), (0, 1)], *plans, on_collision="end")
    assert searching_steps(*episode) == [1, 8]
    assert behaviour_metrics(*episode)["longest_idle"] == 1


def test_before_the_first_step_nothing_was_wasted():
    assert measured(["...."], [(0, 0)], []) == {"longest_idle": 0, "longest_dither": 0, "idle_share": 0}
