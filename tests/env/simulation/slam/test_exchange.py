"""What UAVs whose maps can be wrong exchange: scans and poses, so that no reading counts twice."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import World
from indoor_explorers.env.grid.cells import FREE, Action
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.simulation.radio import CELL_BYTES, POSITION_BYTES
from tests.env.simulation.slam.flights import EVERYTHING, NEVER, begun, disc, random_actions, task
from tests.env.simulation.slam.reference_scans import SlowScans

STAY, RIGHT = int(Action.STAY), int(Action.RIGHT)
seeds = st.integers(0, 2**32)
examples = settings(max_examples=8, deadline=None)
CORRIDOR = Floorplan(np.full((1, 20), FREE, np.uint8), "corridor")


def from_scratch(world, seed, holder):
    """(H, W) sum of the readings of all scans that a holder has, each read once, from where its map has it."""
    slam, (height, width) = world.slam, world.state.truth.shape[1:]
    scans, total = SlowScans(world.scenario, world.state.truth[0], seed), np.zeros((height, width))
    for agent, number in np.argwhere(slam.drawn_at[0, holder] >= 0).tolist():
        origin = divmod(int(slam.true_cell[0, agent, number]), width)
        pose = divmod(int(slam.drawn_at[0, holder, agent, number]), width)
        told = (slam.heading[0, agent, number], slam.bump[0, agent, number])
        for place, value in scans.readings(agent, number, origin, *told).items():
            row, col = place[0] + pose[0] - origin[0], place[1] + pose[1] - origin[1]
            if 0 <= row < height and 0 <= col < width:
                total[row, col] += value
    return total


@examples
@given(
    seeds,
    st.sampled_from([disc(3.0), disc(9.0, loss=0.6), {"radio.model": "unlimited"}]),
    st.sampled_from([{}, {"base.at": "start"}, {"failures.hazard": 0.05}, {"failures.radio_hazard": 0.3}]),
)
def test_no_reading_counts_twice(seed, radio, change):
    world, rng = begun(task(3, radio, EVERYTHING, {"lidar.range": 2.0}, change), seed), np.random.default_rng(seed)
    for _ in range(15):
        world.step(random_actions(rng, world)[None])
    for holder in range(world.slam.log_odds.shape[1]):
        np.testing.assert_array_equal(world.slam.log_odds[0, holder], from_scratch(world, seed, holder))


@examples
@given(seeds, st.sampled_from([disc(3.0), disc(9.0, loss=0.6)]))
def test_linked_uavs_and_the_base_have_the_same_map(seed, radio):
    changes = {"base.at": "start", "base.radius": 3.0}
    world, rng = begun(task(3, radio, EVERYTHING, changes), seed), np.random.default_rng(seed)
    for _ in range(20):
        world.step(random_actions(rng, world)[None])
        for i, j in np.argwhere(world.state.linked[0]):
            np.testing.assert_array_equal(world.slam.log_odds[0, i], world.slam.log_odds[0, j])
        for n in np.flatnonzero(world.state.base_contact[0]):
            np.testing.assert_array_equal(world.slam.log_odds[0, n], world.slam.log_odds[0, -1])
            assert world.view(0, n).base_age == 0


def test_a_team_that_is_always_linked_knows_what_the_team_knows():
    world, rng = begun(task(3, {"radio.model": "unlimited"}, EVERYTHING), 5), np.random.default_rng(5)
    for _ in range(30):
        world.step(random_actions(rng, world)[None])
        for n in range(3):
            np.testing.assert_array_equal(world.slam.log_odds[0, n], world.slam.log_odds[0, 3])


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
