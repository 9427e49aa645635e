"""Teams explore another simulator's graph until each robot knows the map, and hear what its radio lets them hear."""

from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN, Action
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.view import View
from indoor_explorers.evaluation.studies.peers.by_path import MoveChooser, TeamChoice, Turn, shown
from indoor_explorers.evaluation.studies.peers.ir2 import Task
from indoor_explorers.evaluation.studies.peers.ir2_flights import BUDGET, TeamFlight, fly, pilots
from indoor_explorers.planners.random_walk import RandomWalkPilot
from tests.evaluation.studies.peers import team_lattice
from tests.marks import slow

SEED = 7


class Simulator:
    """The small simulator in this process."""

    mended = False

    def begin(self, task: Task) -> Turn:
        return Turn.of(team_lattice.begin(task.part, task.map, 4, 200, task.seed, self.mended))

    def move(self, node: int) -> Turn:
        return Turn.of(team_lattice.move(node))


class Listener(Pilot):
    """Stay, tell a number, and keep what is shown."""

    def __init__(self, number: int) -> None:
        self.number, self.views = number, list[View]()

    def act(self, view: View) -> int:
        self.views.append(view)
        self.message = (float(self.number),)
        return Action.STAY


def _flown(policy: str) -> TeamFlight:
    return fly(Simulator(), policy, Task("hybrid", "1.png", SEED))  # type: ignore[arg-type]


@pytest.fixture
def turn() -> Turn:
    """Return the first turn, in which the first of three rooms is known in part."""
    return Simulator().begin(Task("hybrid", "1.png", SEED))


@pytest.mark.parametrize(
    "policy",
    ["frontier", "frontier-nearest", *slow("rrt", "dddqn")],
)
def test_every_robot_knows_the_map_in_the_end(policy: str) -> None:
    flight = _flown(policy)
    assert (flight.part, flight.map, flight.seed, flight.mended, flight.failure) == ("hybrid", "1", SEED, False, None)
    assert flight.done
    assert flight.explored >= 0.99
    assert flight.pixels <= 16 * np.sqrt(2) * flight.steps
    assert 15 <= flight.steps <= 60  # the far corner is 15 moves away, as the king moves


def test_flights_are_repeatable() -> None:
    assert _flown("frontier-nearest") == _flown("frontier-nearest")


def test_a_policy_that_needs_the_true_map_is_refused_and_one_that_raises_fails_its_flight(monkeypatch) -> None:
    with pytest.raises(InputError, match="policy 'reference' needs the true map, which the simulator does not give"):
        _flown("reference")
    monkeypatch.setattr(RandomWalkPilot, "act", lambda self, view: dict[str, int]()["action"])
    assert _flown("random").failure == "KeyError: 'action'"


def test_only_robots_in_contact_hear_each_other(turn: Turn) -> None:
    """A silent teammate is where it was heard last, and its age grows with its moves; messages come with contacts."""
    team = [Listener(k) for k in range(4)]
    choice = TeamChoice(team, turn, BUDGET)
    assert choice.choose(turn) == turn.node  # a pilot that stays
    first = team[0].views[-1]
    assert [(mate.agent, mate.cell, mate.age, mate.message) for mate in first.mates] == [
        (k, turn.cell(k), 0, None) for k in (1, 2, 3)
    ]
    moved = turn.places.copy()
    moved[0] += 16
    second = replace(turn, robot=1, linked=[0, 1, 2], places=moved)
    choice.exchange(second)
    choice.choose(second)
    assert team[1].views[-1].mates[0] == (0, second.cell(0), 0, (0.0,))
    third = replace(second, robot=3, linked=[2])
    choice.choose(third)
    mate = team[3].views[-1].mates[0]
    assert (mate.cell, mate.message) == (turn.cell(0), None)  # it has not heard of the move
    assert mate.age == round(1.2 * turn.reach)
    choice.choose(replace(third, step=2, robot=3))
    assert team[3].views[-1].mates[0].age == 3 * mate.age


def test_the_map_is_shown_in_cells_of_four_pixels(turn: Turn) -> None:
    belief = turn.belief.copy()
    row, col = (turn.nodes[-1] // 4).tolist()
    belief[4 * row : 4 * row + 4, 4 * col : 4 * col + 4] = OCCUPIED
    belief[:8, :4] = [[UNKNOWN, FREE, FREE, UNKNOWN], [UNKNOWN, UNKNOWN, OCCUPIED, FREE]] * 4
    found = shown(replace(turn, belief=belief))
    assert found.shape == turn.shape == team_lattice.WORLD.shape
    assert found[row, col] == FREE  # a node, whatever its pixels are
    assert found[0, 0] == found[1, 0] == OCCUPIED
    assert (found[2:, 1:] == team_lattice.WORLD[2:, 1:])[found[2:, 1:] != UNKNOWN].all()


def test_of_equal_ways_the_one_with_the_longest_first_move_is_taken() -> None:
    """Nodes at 0, 10, 30 and 60 pixels in a row, all but the farthest ones joined."""
    turn = _in_a_row([0, 10, 30, 60], [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)])
    assert turn.next_node(np.array([60.0, 50.0, 30.0, 0.0])) == 2
    assert turn.next_node(np.array([np.inf, np.inf, np.inf, 0.0])) == 2
    assert turn.next_node(np.full(4, np.inf)) == 0  # nowhere to go
    assert turn.next_node(np.array([0.0, 1.0, 60.0, 60.0])) == 1  # it moves even from the best place


def _in_a_row(columns: list[int], pairs: list[tuple[int, int]]) -> Turn:
    nodes = np.array([(8, column) for column in columns], np.int32)
    both = np.array([(k, k) for k in range(len(nodes))] + pairs + [(b, a) for a, b in pairs], np.int32)
    told = {"robot": 0, "step": 0, "done": False, "linked": [0], "node": 0, "nodes": nodes, "edges": both}
    told |= {"places": nodes[:1], "flown": np.zeros(1), "explored": np.zeros(1)}
    return Turn.of(told | {"belief": np.full((100, 100), FREE, np.uint8)})


def test_a_goal_that_no_node_shows_more_of_is_left(turn: Turn) -> None:
    """The pilot is asked for another goal, and stays once it has none; after some moves it may try again."""
    (pilot,) = pilots("frontier-nearest", 1, turn.shape, SEED)
    belief = np.full_like(turn.belief, OCCUPIED)
    belief[8:40, 8:40] = FREE
    belief[8:16, 40:44] = UNKNOWN  # a pocket that is never seen
    inside = np.flatnonzero((turn.nodes < 40).all(axis=1))
    edges = np.array([(i, j) for i in range(len(inside)) for j in range(len(inside))], np.int32)
    nodes = turn.nodes[inside]
    here = replace(turn, belief=belief, nodes=nodes, edges=edges, places=nodes[:1], node=0, linked=[0])
    choice = TeamChoice([pilot], here, BUDGET)
    went = choice.choose(here)
    assert nodes[went, 1] > nodes[0, 1]
    there = replace(here, places=nodes[went : went + 1], node=went, step=1)
    assert choice.choose(there) == went
    assert choice.choose(replace(there, step=2)) == went


def test_distances_of_a_rule_are_whole_moves(turn: Turn) -> None:
    team = pilots("frontier", 4, turn.shape, SEED)
    TeamChoice(team, turn, BUDGET)
    chooser = team[0].chooser  # type: ignore[attr-defined]
    assert isinstance(chooser, MoveChooser)
    move = turn.reach / 20
    assert chooser._whole(np.array([0.0, 0.4 * move, move, 1.1 * move, 1e9])) == pytest.approx(
        [0.0, move, move, 2 * move, 1e9]
    )
