"""The explorer of one robot, in a building without a transport."""

from dataclasses import dataclass

import numpy as np
import pytest

from indoor_explorers.env import UNKNOWN, Action, InputError, Pilot, Policy, make_policy
from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.robot.bans import MOST_STRIKES, Bans
from indoor_explorers.evaluation.robot.drawings import drawings
from indoor_explorers.evaluation.robot.explorer import Explorer, State
from indoor_explorers.evaluation.robot.occupancy import Area
from indoor_explorers.evaluation.robot.settings import RobotSettings
from tests.evaluation.robot.room import Room, building, grid_of
from tests.marks import slow

ROOMS = building(
    """
    ################
    #......#.......#
    #......#.......#
    #..............#
    #......#.......#
    ####.#####.#####
    #......#.......#
    #......#.......#
    #......#.......#
    ################
    """
)
START = (1, 1)


def explorer_of(policy="frontier-nearest", **settings):
    given = {"cell": 1.0, "radius": 0.3, "lidar_range": 3.0, "settle": 3.0, "ban": 20.0}
    return Explorer(make_policy(policy), RobotSettings(**given | settings))


@pytest.mark.parametrize("policy", ["frontier-nearest", "frontier", "rrt", "dddqn", "pso-robots", "hedac", "sgba"])
def test_a_building_is_explored_and_then_it_is_done(policy):
    room, explorer = Room(ROOMS, START), explorer_of(policy)
    room.explore(explorer)
    assert explorer.state is State.DONE
    assert explorer.status == "done: no frontier is left"
    assert (room.belief[ROOMS == 1] != UNKNOWN).all()
    assert len(room.goals) < 80


@pytest.mark.parametrize("policy", ["pso-robots", *slow("tours"), "dddqn"])
def test_goals_are_some_cells_ahead_for_pilots_that_tell_moves_alone(policy):
    room, explorer = Room(ROOMS, START), explorer_of(policy)
    room.tell(explorer, 0.0)
    goal = explorer.tick(0.0).goal
    row, col = room.frame.cell(goal.x, goal.y)
    assert abs(row - START[0]) + abs(col - START[1]) > 1


def test_the_same_seed_gives_the_same_goals():
    flown = []
    for seed in (0, 0, 1):
        room = Room(ROOMS, START)
        room.explore(explorer_of("frontier-nearest", seed=seed))
        flown.append(room.goals)
    assert flown[0] == flown[1] != flown[2]


def test_a_failed_goal_is_banned_and_another_is_chosen():
    room, explorer = Room(ROOMS, START), explorer_of()
    room.tell(explorer, 0.0)
    first = explorer.tick(0.0).goal
    explorer.goal_ended(False, 1.0)
    assert "is banned for 20 s" in explorer.status
    room.tell(explorer, 2.0)
    second = explorer.tick(2.0).goal
    assert np.hypot(second.x - first.x, second.y - first.y) > 1.0


def test_a_place_that_always_fails_is_given_up_and_told():
    """Behind a pillar that navigation cannot pass, one frontier is left."""
    room = Room(building("#######.# #.....#.# #.......# #######.# #########".replace(" ", "\n")), (1, 1))
    failing = {(2, 4), (2, 5), (2, 6), (2, 7)}
    room.fails = failing
    explorer = explorer_of(ban=5.0)
    room.explore(explorer)
    assert explorer.state is State.DONE
    assert explorer.status.endswith("given up")
    assert sum(goal in failing for goal in room.goals) >= MOST_STRIKES


def test_it_is_not_done_while_the_last_frontier_is_banned():
    room, explorer = Room(ROOMS, START), explorer_of(ban=1000.0)
    room.fails = {(row, col) for row in range(1, 9) for col in range(1, 15)}
    states = []
    for now in range(5):
        room.tell(explorer, float(now))
        command = explorer.tick(float(now))
        if command is not None and command.goal is not None:
            explorer.goal_ended(False, float(now))
        states.append(explorer.state)
    assert State.DONE not in states


def test_done_needs_a_map_without_frontiers_for_a_while_and_a_new_frontier_ends_it():
    closed = building("##### #...# #...# #####".replace(" ", "\n"))
    room, explorer = Room(closed, (1, 2)), explorer_of()
    room.tell(explorer, 0.0)
    assert explorer.tick(0.0) is None
    assert explorer.state is State.EXPLORING
    room.tell(explorer, 3.0)
    explorer.tick(3.0)
    assert explorer.state is State.DONE
    room.belief[2, 1] = UNKNOWN
    room.tell(explorer, 4.0)
    assert explorer.tick(4.0).goal is not None
    assert explorer.state is State.EXPLORING


def test_pause_and_silence_stop_the_robot_and_end():
    room, explorer = Room(ROOMS, START), explorer_of(silence=10.0)
    assert explorer.tick(0.0) is None
    assert explorer.status == "waiting: for a map"
    room.tell(explorer, 0.0)
    assert explorer.tick(0.0).goal is not None
    explorer.running = False
    assert explorer.tick(1.0).goal is None
    assert explorer.state is State.PAUSED
    assert explorer.tick(1.5) is None
    explorer.running = True
    assert explorer.tick(2.0).goal is not None
    explorer.hear_pose(*room.frame.point(START), 0.0, 12.0)
    assert explorer.tick(12.0).goal is None
    assert explorer.status == "silent: no map for 10 s"
    room.tell(explorer, 13.0)
    assert explorer.tick(13.0).goal is not None
    room.belief[...] = room.belief
    explorer.hear_map(grid_of(np.zeros((4, 4)), 0.5), 20.0)
    assert explorer.tick(20.0).goal is None
    assert explorer.status == "silent: no pose for 5 s"


def test_a_robot_that_gets_nowhere_gives_its_goal_up_after_a_while():
    room, explorer = Room(ROOMS, START), explorer_of(patience=10.0)
    goals = []
    for now in range(0, 24, 2):
        room.tell(explorer, float(now))
        command = explorer.tick(float(now))
        goals += [] if command is None else [command.goal]
    assert len(set(goals)) >= 2
    assert "not reached in time" in explorer.status


def test_a_mate_in_the_way_blocks_without_blame_for_the_place():
    settings = {"robots": ("a", "b"), "name": "a", "area": Area(0, 0, 16, 10), "patience": 12.0}
    room, explorer = Room(ROOMS, START), explorer_of(**settings)
    states = set()
    for now in range(0, 30):
        room.tell(explorer, float(now))
        x, y = room.frame.point(START)
        explorer.hear_mate("b", x + 1.0, y, (1.0, 2.0), float(now))
        explorer.hear_mate("unknown", 0.0, 0.0, None, float(now))
        explorer.tick(float(now))
        states.add(explorer.status.partition(" is ")[0])
    assert "blocked: by b" in states
    assert explorer._bans.given_up == 0


def test_mates_share_a_building():
    """Two robots with maps of their own that hear each other's places have different goals from the start."""
    settings = {"robots": ("a", "b"), "area": Area(0, 0, 16, 10)}
    explorers = [explorer_of("frontier-joint", name=name, **settings) for name in "ab"]
    room = Room(ROOMS, (3, 7))
    goals = []
    for k, explorer in enumerate(explorers):
        room.tell(explorer, 0.0)
        other = room.frame.point((3, 7 - k))
        explorer.hear_mate("ba"[k], *other, None, 0.0)
        goals.append(explorer.tick(0.0).goal)
    assert goals[0][:2] != goals[1][:2]


def test_a_map_that_grows_out_of_the_frame_gets_a_larger_one():
    explorer = explorer_of()
    explorer.hear_map(grid_of(np.zeros((8, 8)), 1.0), 0.0)
    first = explorer.frame
    explorer.hear_map(grid_of(np.zeros((9, 9)), 1.0), 1.0)
    assert explorer.frame is first
    explorer.hear_map(grid_of(np.zeros((8, 40)), 1.0), 2.0)
    assert explorer.frame.shape[1] > first.shape[1]
    explorer.hear_pose(30.5, 4.5, 0.0, 2.0)
    assert explorer.tick(2.0).goal is not None


def test_a_robot_beside_a_wall_counts_to_be_in_the_nearest_free_cell():
    room, explorer = Room(ROOMS, START), explorer_of(radius=0.6)
    room.tell(explorer, 0.0)
    assert explorer.tick(0.0).goal is not None


def test_what_is_shown():
    room, explorer = Room(ROOMS, START), explorer_of()
    assert drawings(explorer) == []
    room.tell(explorer, 0.0)
    goal = explorer.tick(0.0).goal
    shown = {each.name: each for each in drawings(explorer)}
    assert shown["goal"].points == [(goal.x, goal.y)] == shown["plan"].points[-1:]
    assert (goal.x, goal.y) in shown["frontiers"].points
    assert shown["candidates"].points
    assert all(len(each.points) == len(each.colours) for each in shown.values())


def test_bans_end_are_lifted_and_become_final():
    bans = Bans(10.0, 1.0)
    bans.add((0.0, 0.0), 0.0)
    bans.add((0.5, 0.0), 5.0)
    assert bans.active(14.0) == [(0.0, 0.0)]
    assert bans.active(15.0) == []
    bans.add((9.0, 0.0), 20.0, strike=False)
    assert bans.lift(21.0)
    assert not bans.lift(21.0)
    assert bans.active(21.0) == []
    bans.add((0.0, 0.0), 22.0)
    assert bans.given_up == 1
    assert not bans.lift(23.0)
    assert bans.active(99.0) == [(0.0, 0.0)]


@dataclass(frozen=True)
class Given(Policy):
    """Make one action, or fail."""

    action: object = Action.STAY

    def pilot(self, briefing):
        return GivenPilot(self.action)


class GivenPilot(Pilot):
    def __init__(self, action):
        self.action = action

    def act(self, view):
        return self.action


def test_where_the_policy_stays_for_long_the_nearest_frontier_is_the_goal():
    room, explorer = Room(ROOMS, START), Explorer(Given(), explorer_of(patience=10.0).settings)
    room.explore(explorer)
    assert explorer.state is State.DONE
    assert len(room.goals) > 3


def test_a_policy_that_drives_into_a_wall_stays_and_one_that_fails_is_told_in_a_line():
    room, explorer = Room(ROOMS, START), Explorer(Given(Action.UP), explorer_of().settings)
    room.tell(explorer, 0.0)
    assert explorer.tick(0.0) is None
    explorer = Explorer(Given("up"), explorer_of().settings)
    room.tell(explorer, 0.0)
    with pytest.raises(RunError, match="the policy failed at step 0") as caught:
        explorer.tick(0.0)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"robots": ("a", "b"), "name": "c", "area": Area(0, 0, 1, 1)}, "expected --name among"),
        ({"robots": ("a", "a"), "name": "a"}, "expected --name among"),
        ({"robots": ("a", "b"), "name": "a"}, "expected --area"),
        ({"area": Area(3, 0, 1, 1)}, "X0 < X1"),
        ({"robots": ("1 b",), "name": "1 b"}, "namespaces of ROS"),
        ({"settings": {"radio.rnage": 3}}, "radio.range"),
    ],
)
def test_wrong_settings_are_refused_in_a_line(settings, said):
    with pytest.raises(InputError, match=said) as caught:
        explorer_of(**settings)
    assert "\n" not in str(caught.value)


def test_policies_that_need_the_map_are_refused():
    with pytest.raises(InputError, match="given the map"):
        explorer_of("reference")
