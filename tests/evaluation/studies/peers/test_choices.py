"""Pilots explore a graph of viewpoints to its end, and tours keep in view all that is left to see."""

import numpy as np
import pytest

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.evaluation.studies.peers.by_cells import SCALE, shown
from indoor_explorers.evaluation.studies.peers.flights import EXPERT, chosen_by, fly
from indoor_explorers.evaluation.studies.peers.graph import GraphState
from indoor_explorers.evaluation.studies.peers.tours import TourPlanner
from indoor_explorers.planners.random_walk import RandomWalkPilot
from tests.evaluation.studies.peers import lattice

TOUR = "frontier-tour"


class Simulator:
    """The small simulator in this process."""

    scans_on_the_way = False

    def begin(self, name: str, seed: int) -> GraphState:
        return GraphState.of(lattice.begin(name, seed), 0.4)

    def move(self, node: int | None) -> GraphState:
        return GraphState.of(lattice.step(node, self.scans_on_the_way), 0.4)


@pytest.fixture
def state() -> GraphState:
    """Return a state in which two rooms have been seen in part."""
    simulator = Simulator()
    found = simulator.begin("1.png", 0)
    for _ in range(6):
        found = simulator.move(None)
    return found


def _flown(policy: str, adapter: str = "auto"):
    return fly(Simulator(), policy, adapter, "1.png", 0)  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("policy", "adapter", "how"),
    [
        (EXPERT, "auto", "own"),
        (TOUR, "auto", "nodes"),
        ("frontier", "auto", "nodes"),
        ("rrt", "auto", "nodes"),
        ("frontier", "cells", "cells"),
        ("frontier-nearest", "auto", "cells"),
        ("random", "auto", "cells"),
    ],
)
def test_every_policy_explores_the_graph_to_its_end(policy: str, adapter: str, how: str) -> None:
    """A pilot without goals, such as a random one, is only led to where something is left to see."""
    flight = _flown(policy, adapter)
    assert (flight.chosen_by, flight.failure) == (how, None)
    assert flight.done
    assert flight.explored == 1.0
    assert flight.metres_90 is not None
    assert flight.metres_99 is not None
    assert 0 < flight.metres_90 <= flight.metres_99 <= flight.metres
    assert 4.0 * flight.moves <= flight.metres <= 5.7 * flight.moves


def test_tours_are_shorter_than_greedy_flights() -> None:
    """The tour planner, and the rule of `frontier` among its nodes, need less than the nearest useful node does."""
    nearest, tour = _flown(EXPERT).metres, _flown(TOUR)
    assert tour.metres < 0.9 * nearest
    assert _flown("frontier").metres < 0.9 * nearest
    assert _flown(TOUR) == tour


def test_a_tour_has_every_point_in_view_and_no_node_twice(state: GraphState) -> None:
    tour = TourPlanner(np.random.default_rng(0)).plan(state)
    assert len(set(tour.tolist())) == len(tour)
    assert set(tour.tolist()) <= set(state.useful.tolist())
    entered, here = [], state.node
    for node in tour.tolist():
        before = state.ways(np.array([here]))[1][0]
        at = node
        while at != here:
            entered.append(at)
            at = int(before[at])
        here = node
    assert (state.in_view[entered].any(axis=0) == state.in_view.any(axis=0)).all()


def test_distances_and_moves_are_along_the_edges(state: GraphState) -> None:
    edges = {tuple(edge) for edge in state.edges.tolist()}
    assert len(state.useful) > 2
    for target in state.useful.tolist():
        here, metres = state.node, 0.0
        first = state.first_move(target)
        assert (here, first) in edges
        step = 0.4 * np.hypot(*(state.nodes[here] - state.nodes[first]))
        metres = step + state.ways(np.array([first]))[0][0, target]
        assert metres == pytest.approx(state.away[target])
    assert (np.diff(state.away[state.useful]) >= 0).all()


def test_the_shown_map_has_the_frontier_of_the_simulator_alone(state: GraphState) -> None:
    """Unknown cells beside free ones are near counted points; all reachable nodes are on free cells."""
    belief = shown(state)
    assert state.belief.shape == (41, 121)
    assert belief.shape == (21, 61)
    assert (belief[tuple(state.nodes.T // SCALE)] == FREE).all()
    free, unknown = (np.argwhere(belief == value) for value in (FREE, UNKNOWN))
    beside = unknown[(np.abs(unknown[:, None] - free).max(axis=2) <= 1).any(axis=1)]
    assert len(beside) > 0
    apart = np.abs(beside[:, None] - state.frontiers // SCALE).max(axis=2).min(axis=1)
    assert apart.max() <= 2
    counted = state.__class__(**(vars(state) | {"frontiers": state.frontiers[:0]}))
    sealed = shown(counted)
    unknown = np.argwhere(sealed == UNKNOWN)
    assert not (np.abs(unknown[:, None] - np.argwhere(sealed == FREE)).max(axis=2) <= 1).any()
    assert (sealed == OCCUPIED).sum() > (belief == OCCUPIED).sum()


def test_a_policy_without_sequences_cannot_be_flown_by_nodes() -> None:
    with pytest.raises(InputError, match="policy 'frontier-nearest' has no rule for nodes; use auto or cells"):
        chosen_by("frontier-nearest", "nodes")


def test_a_policy_that_needs_the_true_map_is_refused() -> None:
    with pytest.raises(InputError, match="policy 'reference' needs the true map, which the simulator does not give"):
        chosen_by("reference", "auto")


def test_a_policy_that_raises_fails_its_flight_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RandomWalkPilot, "act", lambda self, view: dict[str, int]()["action"])
    flight = _flown("random")
    assert flight.failure == "KeyError: 'action'"
    assert not flight.done
