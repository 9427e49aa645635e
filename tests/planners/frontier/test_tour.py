from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.planners.frontier.tour import DistanceCache, FrontierTour
from indoor_explorers.planners.toolbox.navigation.paths import Paths
from tests.planners.flights import view_of

from .test_group_pilot import corridor, pilot_of


def test_it_takes_the_lone_frontier_first_when_that_saves_the_way_back() -> None:
    belief = np.full((5, 30), 2, np.uint8)
    belief[2, :21] = 1
    belief[2, 21:] = 0
    for col in (8, 13, 17):  # short side corridors
        belief[3, col] = 1
        belief[4, col] = 0
    belief[2, 0] = 0  # and an end that is only a little farther than the nearest of them
    pilot = pilot_of(FrontierTour(), 0, (5, 30))
    pilot.act(view_of(belief, (2, 5)))
    assert pilot.goal == (2, 1)


def test_kept_distances_are_those_searched_for(belief: Belief) -> None:
    rng = np.random.default_rng(1)
    free = np.flatnonzero(belief == FREE).astype(np.int32)
    between = DistanceCache(Paths((belief.shape[0], belief.shape[1])))
    for count in (3, 10, 7, 0, 5, 12):
        places = rng.choice(free, min(count, len(free)), replace=False)
        expected = Paths((belief.shape[0], belief.shape[1])).matrix(belief, places)
        assert (between.steps(belief, places) == expected).all()


def test_distances_that_were_kept_are_never_too_short() -> None:
    between, paths = DistanceCache(Paths((1, 20))), Paths((1, 20))
    places = np.array([5, 14], np.int32)
    walled = corridor()
    walled[0, 9] = 2
    assert between.steps(walled, places)[0, 1] > 1000
    assert (between.steps(corridor(), places) == paths.matrix(corridor(), places)).all()
