from __future__ import annotations

from typing import Any

import numpy as np

from indoor_explorers.env import Mate, View
from indoor_explorers.planners.frontier.latency import FrontierLatency
from tests.planners.flights import view_of

from .test_group_pilot import corridor, pilot_of


def in_corridor(mates: tuple[Mate, ...]) -> tuple[Any, View]:
    """A UAV in column 8 of a corridor of which the columns 5 to 14 are known."""
    return pilot_of(FrontierLatency(), 0, (1, 20)), view_of(corridor(), (0, 8), mates)


def test_it_leaves_a_frontier_to_the_mate_that_is_nearer() -> None:
    for mates, goal in [((), (0, 5)), ((Mate(1, (0, 6), 0, None),), (0, 14))]:
        pilot, view = in_corridor(mates)
        assert pilot.choose(view) == goal


def test_every_mate_that_is_nearer_halves_a_gain() -> None:
    pilot, view = in_corridor((Mate(1, (0, 6), 0, None),))
    cells, steps = np.array([5, 14], np.int32), np.array([3, 6], np.int32)
    assert pilot.factors(view, cells, steps).tolist() == [0.5, 1.0]
