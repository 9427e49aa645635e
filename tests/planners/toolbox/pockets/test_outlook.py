from __future__ import annotations

import numpy as np

from indoor_explorers.planners.toolbox.pockets.estimates import PocketEstimates
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS
from indoor_explorers.planners.toolbox.pockets.outlook import ClusterJudge, Outlook, OutlookParameters
from tests.planners.flights import world_on


def outlook(
    sizes: list[float],
    away: list[int],
    *,
    known: int = 1000,
    goal: float = 1.0,
    skip: float = 1.0,
    tails: np.ndarray | None = None,
) -> Outlook:
    """The outlook of clusters that hide these numbers of cells, some steps away, at a lidar range of 3."""
    world = world_on(np.ones((4, 4), np.bool_), [(0, 0)], goal=goal)
    judge = ClusterJudge(world.briefing(0, 0), OutlookParameters(skip=skip))
    tails = np.zeros((len(sizes), len(THRESHOLDS))) if tails is None else tails
    estimates = PocketEstimates(tails, np.array(sizes), np.zeros(len(sizes)))
    return judge.outlook(estimates, known, np.array(away, np.int32))


def test_the_smallest_pockets_wait_up_to_what_may_stay_unknown() -> None:
    assert outlook([3.0, 50.0, 4.0, 4.0], [9, 9, 9, 9]).deferred.tolist() == [True, False, True, False]
    assert outlook([3.0, 50.0, 4.0, 4.0], [9, 9, 9, 9], skip=1.1).deferred.tolist() == [True, False, True, True]
    assert outlook([3.0, 50.0, 4.0, 4.0], [9, 9, 9, 9], known=300).deferred.tolist() == [True, False, False, False]


def test_of_equal_pockets_the_farther_waits() -> None:
    assert outlook([6.0, 6.0], [10, 40]).deferred.tolist() == [False, True]


def test_what_is_near_does_not_wait() -> None:
    assert outlook([1.0, 1.0], [2, 3]).deferred.tolist() == [False, True]


def test_the_goal_tells_what_may_stay_unknown_if_it_is_lower_than_the_aim() -> None:
    assert outlook([50.0], [9], goal=0.9).deferred.tolist() == [True]
    assert outlook([50.0], [9], goal=0.99).deferred.tolist() == [False]
    assert outlook([5.0], [9], goal=1.0).deferred.tolist() == [True]


def test_what_may_hide_much_does_not_wait() -> None:
    tails = np.zeros((2, len(THRESHOLDS)))
    tails[0, : THRESHOLDS.index(2) + 1] = 0.2  # more than a quarter of 10 cells
    tails[1, : THRESHOLDS.index(1) + 1] = 0.2
    assert outlook([1.0, 1.0], [9, 9], tails=tails).deferred.tolist() == [False, True]


def test_chances_are_those_of_any_cell() -> None:
    tails = np.array([1.0, 0.5, 0.0])[:, None].repeat(len(THRESHOLDS), axis=1)
    assert outlook([1.0, 2.0, 3.0], [5, 5, 5], tails=tails).chances.tolist() == [1.0, 0.5, 0.0]
