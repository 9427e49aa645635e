from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import Mate
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.sensing.lidar import scan, view_gain
from indoor_explorers.planners.frontier.advantage import FrontierAdvantage
from indoor_explorers.planners.frontier.burgard import FrontierBurgard, nearness
from indoor_explorers.planners.frontier.mrtsp import FrontierMrtsp
from indoor_explorers.planners.frontier.utility import Form, FrontierUtility
from tests.planners.flights import view_of

from .test_group_pilot import corridor, pilot_of

BELIEF = np.array(
    [
        [0, 0, 0, 0, 0, 0, 0, 0, 0],
        [0, 0, 0, 0, 0, 0, 0, 0, 0],
        [1, 1, 1, 1, 1, 1, 1, 1, 1],
        [2, 2, 2, 2, 2, 1, 2, 2, 2],
        [2, 2, 2, 2, 2, 1, 0, 2, 2],
    ],
    np.uint8,
)


@pytest.mark.parametrize("form", ["size", "difference", "discounted"])
def test_scores_are_the_formulas(form: Form) -> None:
    pilot = pilot_of(FrontierUtility(form=form, cost=0.5), 0, (5, 9))
    view, reach = view_of(BELIEF, (3, 5)), 3.0
    choices = pilot.choices(view, pilot.members(view))
    gains, steps = pilot.gains(view, choices), choices.steps.astype(np.float64)
    if form == "size":
        assert sorted(gains.tolist()) == sorted(np.diff(choices.clusters.ends).tolist()) == [1, 2, 3, 4]
        expected = gains - 0.5 * steps
    else:
        cells = [divmod(cell, 9) for cell in choices.viewpoints().tolist()]
        assert gains.tolist() == [view_gain(BELIEF, cell, reach) for cell in cells]
        expected = gains - 0.5 * reach * steps if form == "difference" else gains * np.exp(-0.5 * steps / reach)
    np.testing.assert_allclose(pilot.score(gains, steps), expected)


def test_the_weight_of_the_path_decides_between_large_and_near() -> None:
    goals = []
    for cost in (0.01, 100.0):
        pilot = pilot_of(FrontierUtility(form="discounted", cost=cost), 0, (5, 9))
        pilot.act(view_of(BELIEF, (3, 5)))
        goals.append(pilot.goal)
    assert goals[0] is not None
    assert goals[0][0] == 2
    assert goals[1] in {(4, 5), (2, 5)}


def test_the_ratio_is_path_cost_by_size_and_the_turn_towards_the_first_cluster() -> None:
    belief = np.full((5, 21), 2, np.uint8)
    belief[2] = 1
    belief[1:4, 0] = belief[2, 20] = 0  # three frontier cells in the west, one in the east
    belief[1:4, 1] = 1
    pilot = pilot_of(FrontierMrtsp(switch_cost=0.0), 0, belief.shape)
    expected = {(2, 1): (7 + 0 - 3) / 3, (2, 19): (11 + 0 - 3) / 1}  # no flight so far, so no turn
    for cell, turned in (((2, 8), {}), ((2, 9), {(2, 1): 2, (2, 19): 0}), ((2, 12), {(2, 1): 2, (2, 19): 0})):
        view = view_of(belief, cell)
        choices = pilot.choices(view, pilot.members(view))
        scores = pilot.score(pilot.gains(view, choices), choices.steps.astype(np.float64))[0]
        moved = {(2, 1): (cell[1] - 8) / 3, (2, 19): 8 - cell[1]}
        places = [divmod(place, 21) for place in choices.cells[0].tolist()]
        wanted = [expected[place] + moved[place] + turned.get(place, 0) for place in places]
        np.testing.assert_allclose(-scores, wanted, atol=1e-9)
    pilot.act(view_of(belief, (2, 10)))
    assert pilot.goal == (2, 1)


#: A corridor with three openings to the north: two in the west, close together, and one in the east.
CORRIDOR = np.full((4, 30), 2, np.uint8)
CORRIDOR[2, 3:27] = 1
CORRIDOR[0, :] = 0
CORRIDOR[1, [8, 10, 25]] = 1


def goal_of(policy: FrontierAdvantage, cell: Cell) -> Any:
    pilot = pilot_of(policy, 0, (4, 30))
    pilot.act(view_of(CORRIDOR, cell))
    return pilot.goal


def test_an_advantage_is_the_formula() -> None:
    pilot = pilot_of(FrontierAdvantage(remoteness=0.5, reach=4.0), 0, (4, 30))
    view = view_of(CORRIDOR, (2, 17))
    choices = pilot.choices(view, pilot.members(view))
    columns = (choices.viewpoints() % 30).tolist()
    assert sorted(columns) == [8, 10, 25]
    # between columns 8 and 10 are 4 steps; from 25 to the others 19 and 17, more than 4 lidar ranges of 3
    expected = {8: (4 + 12) / 2, 10: (4 + 12) / 2, 25: 12.0}
    np.testing.assert_allclose(pilot.gains(view, choices), [0.5 * expected[col] for col in columns])


def test_the_remote_cluster_comes_first_of_two_about_as_near() -> None:
    assert goal_of(FrontierAdvantage(remoteness=0.0), (2, 17)) == (1, 10)
    assert goal_of(FrontierAdvantage(remoteness=1.0), (2, 17)) == (1, 25)
    assert goal_of(FrontierAdvantage(remoteness=1.0), (2, 11)) == (1, 10)


@pytest.mark.parametrize("reach", [1.0, 3.0, 6.5])
def test_nearness_falls_with_distance_and_behind_what_a_scan_cannot_see(belief: Belief, reach: float) -> None:
    cells = np.arange(belief.size, dtype=np.int32)
    origin = int(np.flatnonzero(belief == 1)[-1])
    transparent = np.where(belief == 2, 2, 1).astype(np.uint8)
    row, col = divmod(origin, belief.shape[1])
    seen = scan(transparent, (row, col), reach).ravel() > 0
    away = np.hypot(cells // belief.shape[1] - row, cells % belief.shape[1] - col)
    expected = np.where(seen, np.maximum(0, 1 - away / reach), 0.0)
    np.testing.assert_allclose(nearness(belief, origin, cells, reach), expected)


def test_the_second_uav_turns_to_where_the_first_does_not_look() -> None:
    belief = np.ones((9, 9), np.uint8)
    belief[0], belief[8] = 0, 0
    cells, rows = [(3, 4), (4, 4)], []
    for agent in (0, 1):
        pilot = pilot_of(FrontierBurgard(), agent, (9, 9))
        pilot.act(view_of(belief, cells[agent], (Mate(1 - agent, cells[1 - agent], 0, None),)))
        assert pilot.goal is not None
        rows.append(pilot.goal[0])
    assert rows == [1, 7]


def test_without_weight_both_take_the_nearest() -> None:
    cells = [(0, 7), (0, 8)]
    for agent in (0, 1):
        pilot = pilot_of(FrontierBurgard(weight=0.0), agent, (1, 20))
        pilot.act(view_of(corridor(), cells[agent], (Mate(1 - agent, cells[1 - agent], 0, None),)))
        assert pilot.goal == (0, 5)
