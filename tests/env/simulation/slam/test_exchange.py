"""What UAVs whose maps can be wrong exchange: scans and poses, so that no reading counts twice."""

import numpy as np

from indoor_explorers.env import World
from indoor_explorers.env.grid.cells import FREE, Action
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.simulation.radio import CELL_BYTES, POSITION_BYTES
from tests.env.simulation.slam.flights import NEVER, disc, task

STAY, RIGHT = int(Action.STAY), int(Action.RIGHT)
CORRIDOR = Floorplan(np.full((1, 20), FREE, np.uint8), "corridor")


def test_mates_tell_where_they_believe_to_be():
    changes = {"drift.rate": 0.5, "drift.closures": 0.0, "drift.mates": False}
    world = World(task(2, {"radio.model": "unlimited"}, changes))
    world.begin(0, 2, floorplan=CORRIDOR, spawns=[(0, 2), (0, 8)])
    for _ in range(6):
        world.step(np.array([[STAY, RIGHT]]))
        assert world.view(0, 0).mates[0].cell == world.view(0, 1).cell
    assert tuple(world.state.cell[0, 1].tolist()) != world.view(0, 1).cell == (0, 14)


def test_bytes_are_readings_that_are_new_and_positions():
    scenario = task(2, disc(8.0), NEVER, {"lidar.range": 2.0})
    world = World(scenario)
    world.begin(0, 0, floorplan=CORRIDOR, spawns=[(0, 0), (0, 9)])
    assert not world.state.sent_bytes.any()
    world.step(np.array([[RIGHT, STAY]]))
    first = (3 + 4) * CELL_BYTES + POSITION_BYTES
    second = (5 + 5) * CELL_BYTES + POSITION_BYTES
    assert world.state.sent_bytes[0].tolist() == [first, second]
    assert world.state.received[0].tolist() == [5, 4]
    world.step(np.array([[STAY, STAY]]))
    assert (world.state.sent_bytes[0] - [first, second]).tolist() == [4 * CELL_BYTES + 8, 5 * CELL_BYTES + 8]
    assert world.state.received[0].tolist() == [0, 0]


def test_what_only_stopped_uavs_knew_is_lost_and_what_they_told_is_not():
    stops = {"failures.stops": ((1, 3),), "lidar.range": 1.0}
    for reach, kept in ((0.0, [0, 1, 2, 3]), (4.0, [0, 1, 2, 3, 4, 5, 6])):
        world = World(task(2, disc(reach), NEVER, stops))
        world.begin(0, 0, floorplan=CORRIDOR, spawns=[(0, 1), (0, 4)])
        for actions in ([STAY, RIGHT], [STAY, STAY], [RIGHT, RIGHT]):
            world.step(np.array([actions]))
        assert np.flatnonzero(world.state.union[0, 0]).tolist() == kept
        assert world.state.team_covered[0] == len(kept)
