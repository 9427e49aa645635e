from __future__ import annotations

from typing import Any

import numpy as np

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.planners.frontier.advantage import FrontierAdvantage
from tests.planners.flights import view_of

from .test_group_pilot import pilot_of

#: A corridor with three openings to the north: two in the west, close together, and one in the east.
CORRIDOR = np.full((4, 30), 2, np.uint8)
CORRIDOR[2, 3:27] = 1
CORRIDOR[0, :] = 0
CORRIDOR[1, [8, 10, 25]] = 1


def goal_of(policy: FrontierAdvantage, cell: Cell) -> Any:
    pilot = pilot_of(policy, 0, (4, 30))
    pilot.act(view_of(CORRIDOR, cell))
    return pilot.goal


def test_scores_are_the_formula() -> None:
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
