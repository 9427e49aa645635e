from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import InputError, Mate, View, World, scenario
from indoor_explorers.env.arrays import Cell
from indoor_explorers.env.grid import distance_field
from indoor_explorers.planners.clusters import frontier_clusters
from indoor_explorers.planners.coordination.places import steps_to
from indoor_explorers.planners.coordination.split import Sharing, WorkSplit, message_of
from indoor_explorers.planners.coordination.unlinked import LEAST
from indoor_explorers.planners.teammates import CLAIM_STEPS, MEMORY

#: A corridor from left to right through unknown land, open at both ends and known in between.
CORRIDOR = np.full((9, 60), 2, np.uint8)
CORRIDOR[4, 10:50] = 1
CORRIDOR[4, :10] = CORRIDOR[4, 50:] = 0
CORRIDOR[3, 30], CORRIDOR[2, 30] = 1, 0


def split_of(team: int, radio: str = "disc", agent: int = 0) -> WorkSplit:
    world = World(scenario("thesis-open").with_settings({"team": team, "radio.model": radio, "radio.range": 5.0}))
    world.reset([0])
    return WorkSplit(replace(world.briefing(0, agent), shape=CORRIDOR.shape), Sharing())


def shares(split: WorkSplit, cell: Cell, *mates: Mate, goal: Cell | None = None) -> NDArray[np.float64]:
    """The shares of the corridor's left end, its branch in the middle, and its right end."""
    view = View(CORRIDOR, cell, np.ones(5, np.bool_), 100, 1000, mates, CORRIDOR == 3)
    clusters = frontier_clusters(CORRIDOR, 5.0)
    own = steps_to(clusters, distance_field(CORRIDOR, cell))
    found = split.shares(view, clusters, own, lambda place: distance_field(CORRIDOR, place), goal)
    assert found.shape == (3,)
    assert (found > 0.0).all()
    assert (found <= 1.0).all()
    columns = clusters.cells % 60
    return found[np.argsort(columns)]


def test_alone_everything_is_ones_own() -> None:
    assert shares(split_of(1), (4, 30)).tolist() == [1.0, 1.0, 1.0]


def test_linked_uavs_part_ways_although_they_know_the_same() -> None:
    cells = [(4, 29), (4, 30), (4, 31)]
    best = []
    for agent in range(3):
        mates = [Mate(k, cells[k], 0, None) for k in range(3) if k != agent]
        found = shares(split_of(3, agent=agent), cells[agent], *mates)
        steps = np.array([abs(cells[agent][1] - 10), abs(cells[agent][1] - 30) + 1, abs(cells[agent][1] - 49)])
        best.append(int((found * np.exp(-2.5 * steps / 20.0)).argmax()))
    assert sorted(best) == [0, 1, 2]


def test_whoever_flies_to_a_cluster_keeps_it() -> None:
    branch = (3.0, 30.0)
    assert shares(split_of(2), (4, 31), Mate(1, (4, 29), 0, None))[1] == 1.0
    assert shares(split_of(2), (4, 31), Mate(1, (4, 29), 0, branch))[1] == pytest.approx(0.01)
    assert shares(split_of(2), (4, 31), Mate(1, (4, 29), 0, branch), goal=(3, 30))[1] == 1.0


def test_a_silent_teammate_keeps_what_it_is_nearer_to() -> None:
    left, middle, right = shares(split_of(2), (4, 31), Mate(1, (4, 14), 12, None))
    assert left < middle == right == 1.0
    assert left == pytest.approx(max(LEAST, np.exp(-(21 - 4) / (0.3 * 3.0))))


def test_a_silent_teammate_is_taken_to_be_where_it_said_it_goes() -> None:
    said = shares(split_of(2), (4, 31), Mate(1, (4, 40), CLAIM_STEPS, (4.0, 10.0)))
    stale = shares(split_of(2), (4, 31), Mate(1, (4, 40), CLAIM_STEPS + 1, (4.0, 10.0)))
    assert said[0] < 1.0 == said[2]
    assert stale[2] < 1.0 == stale[0]


def test_a_lost_teammate_keeps_nothing() -> None:
    assert shares(split_of(2), (4, 31), Mate(1, (4, 14), MEMORY + 1, (4.0, 10.0))).tolist() == [1.0, 1.0, 1.0]
    near_by = Mate(1, (4, 31), 2, (4.0, 10.0))
    assert shares(split_of(2), (4, 31), near_by).tolist() == [1.0, 1.0, 1.0]


def test_those_that_never_heard_of_each_other_keep_to_sectors() -> None:
    found = [shares(split_of(2, "none", agent), (4, 30)) for agent in range(2)]
    assert (found[0] != found[1]).any()
    assert found[0] != pytest.approx(1.0)
    heard = Mate(1, (4, 14), MEMORY + 1, None)
    assert shares(split_of(2, "none"), (4, 30), heard).tolist() == [1.0, 1.0, 1.0]


def test_messages_are_goals() -> None:
    assert message_of((3, 4)) == (3.0, 4.0)
    assert message_of(None) is None


def test_bad_parameters_are_refused() -> None:
    with pytest.raises(InputError, match="expected hold of at least 1"):
        Sharing(hold=0.5)
