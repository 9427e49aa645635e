from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.view import View
from indoor_explorers.env.search.bfs import distances_from
from indoor_explorers.env.sensing.lidar import view_gain
from indoor_explorers.planners.sampling import memory
from indoor_explorers.planners.sampling.memory import ViewpointMemory
from indoor_explorers.planners.sampling.rrt_aep import RrtAep


def half_known() -> tuple[ViewpointMemory, View, np.ndarray]:
    world = World(scenario("thesis-open"))
    world.begin(0, 0, floorplan=Floorplan.from_free(np.ones((12, 30), np.bool_), "open"), spawns=[(6, 4)])
    belief = np.zeros((12, 30), np.uint8)
    belief[:, :15] = FREE
    visited = np.zeros(belief.shape, np.bool_)
    visited[6, :13] = True
    view = View(belief, (6, 4), np.ones(5, np.bool_), 0, 99, (), visited)
    steps = np.empty(belief.shape, np.int32)
    distances_from(belief, 6, 4, np.empty(belief.size, np.int32), steps)
    policy = make_policy("rrt-aep")
    assert isinstance(policy, RrtAep)
    return ViewpointMemory(world.briefing(0, 0), policy), view, steps.ravel()


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


def test_what_shows_nothing_any_more_is_forgotten() -> None:
    kept, view, steps = half_known()
    kept.grow(view, (30.0, 200))
    assert len(kept.recalled(view, steps)[0])
    assert not len(kept.recalled(view._replace(belief=np.full((12, 30), FREE, np.uint8)), steps)[0])
    assert not len(kept.recalled(view, steps)[0])


def test_what_cannot_be_reached_is_forgotten() -> None:
    kept, view, steps = half_known()
    kept.grow(view, (30.0, 200))
    assert not len(kept.recalled(view, np.full_like(steps, UNREACHABLE))[0])
    assert not len(kept.recalled(view, steps)[0])


def test_what_is_not_judged_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    kept, view, steps = half_known()
    kept.grow(view, (30.0, 200))
    monkeypatch.setattr(memory, "JUDGED", 1)
    found = [kept.recalled(view, steps)[0] for _ in range(2)]
    assert max(map(len, found)) <= 1
    monkeypatch.setattr(memory, "JUDGED", 1000)
    assert len(kept.recalled(view, steps)[0]) > 5
