from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.policies.view import View
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.sensing.lidar import lidar_model, view_gain
from indoor_explorers.planners.sampling import rrt_aep
from indoor_explorers.planners.sampling.rrt_aep import RrtAep, ViewpointMemory
from tests.planners.flights import fly, rooms, view_of, world_on


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


def half_known() -> tuple[ViewpointMemory, View, np.ndarray]:
    world = world_on(np.ones((12, 30), np.bool_), [(6, 4)])
    belief = np.zeros((12, 30), np.uint8)
    belief[:, :15] = FREE
    visited = np.zeros(belief.shape, np.bool_)
    visited[6, :13] = True
    view = view_of(belief, (6, 4))._replace(visited=visited)
    return (
        ViewpointMemory(world.briefing(0, 0), RrtAep(), lidar_model(3.0)),
        view,
        distance_field(belief, (6, 4)).ravel(),
    )


def test_what_is_recalled_shows_something_and_the_nearest_comes_first() -> None:
    kept, view, steps = half_known()
    kept.grow(view, (6.0, 50), (30.0, 200))
    cells, gains = kept.recalled(view, steps)
    assert len(cells) == len(gains) == len(set(cells.tolist())) > 5
    assert (np.diff(steps[cells]) >= 0).all()
    assert not view.visited.ravel()[cells].any()
    for cell, gain in zip(cells.tolist(), gains.tolist(), strict=True):
        assert gain > 0.0
        assert view_gain(view.belief, divmod(cell, 30), 3.0) > 0


def test_viewpoints_that_show_nothing_or_cannot_be_reached_are_forgotten() -> None:
    kept, view, steps = half_known()
    everything_known = view._replace(belief=np.full((12, 30), FREE, np.uint8))
    for now, ways in ((everything_known, steps), (view, np.full_like(steps, UNREACHABLE))):
        kept.grow(view, (30.0, 200))
        assert len(kept.recalled(view, steps)[0])
        assert not len(kept.recalled(now, ways)[0])
        assert not len(kept.recalled(view, steps)[0])


def test_what_is_not_judged_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    kept, view, steps = half_known()
    kept.grow(view, (30.0, 200))
    monkeypatch.setattr(rrt_aep, "JUDGED", 1)
    found = [kept.recalled(view, steps)[0] for _ in range(2)]
    assert max(map(len, found)) <= 1
    monkeypatch.setattr(rrt_aep, "JUDGED", 1000)
    assert len(kept.recalled(view, steps)[0]) > 5
