from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.planners.sampling.memory import ViewpointMemory
from indoor_explorers.planners.toolbox.navigation.teammates import message_of
from tests.planners.flights import fly, rooms


def test_it_needs_fewer_steps_than_the_nearest_frontier() -> None:
    maps = [*(rooms(3, 9, seed) for seed in range(2)), *(np.ones((16, 16), np.bool_),) * 2]
    steps = {
        name: [fly(make_policy(name), free, seed=seed).steps for seed, free in enumerate(maps)]
        for name in ("rrt-aep", "frontier-nearest")
    }
    assert sum(steps["rrt-aep"]) < 0.95 * sum(steps["frontier-nearest"])


def test_trees_are_grown_now_and_then(monkeypatch: pytest.MonkeyPatch) -> None:
    grown: list[int] = []
    grow = ViewpointMemory.grow

    def noted(self: ViewpointMemory, view: Any, *squares: tuple[float, int]) -> None:
        grown.append(len(squares))
        grow(self, view, *squares)

    monkeypatch.setattr(ViewpointMemory, "grow", noted)
    counts = []
    for period in (0.0, 4.0):
        grown.clear()
        policy = make_policy("rrt-aep", local_period=period, global_period=period)
        flight = fly(policy, rooms(3, 9, 1), lidar=5.0)
        assert flight.complete
        plans = flight.pilots[0].tally()["plans"]
        counts.append((grown.count(2) / plans, grown.count(1) / plans))
    assert counts[0] == (1.0, 1.0)
    assert 0.0 < counts[1][0] < 0.8
    assert counts[1][0] == counts[1][1]


def test_where_trees_find_nothing_the_nearest_frontier_is_next() -> None:
    policy = make_policy("rrt-aep", samples=1, near_samples=0, bias=0.0, local_ranges=0.5)
    flight = fly(policy, rooms(2, 4, 0), budget=2000)
    assert flight.complete
    assert flight.pilots[0].tally()["fallbacks"] > 0


def test_it_tells_its_goal() -> None:
    flight = fly(make_policy("rrt-aep"), rooms(3, 5, 1), team=2, radio=("unlimited", 0.0), budget=12)
    for pilot in flight.pilots:
        assert pilot.message == message_of(pilot.goal)


@pytest.mark.parametrize("radio", [("none", 0.0), ("disc", 4.0), ("unlimited", 0.0)], ids=lambda radio: radio[0])
def test_nobody_dithers(radio: tuple[str, float]) -> None:
    flight = fly(make_policy("rrt-aep"), rooms(3, 5, 2), team=4, radio=radio)
    assert flight.complete
    assert flight.longest_dither <= 6
