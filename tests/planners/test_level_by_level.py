"""One level after the other."""

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.grid.cells import FREE, Action
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.planners.level_by_level import LevelByLevel

TASK = scenario("small-storeys").for_evaluation()


def moves(policy, task, seed, steps=2000):
    """Yield the world before each step, with the pilots and the actions that they then take."""
    world = World(task)
    world.reset([seed])
    pilots = [policy.pilot(world.briefing(0, n)) for n in range(task.team)]
    while world.flying.any() and world.state.step[0] < steps:
        actions = [pilot.act(world.view(0, n)) for n, pilot in enumerate(pilots)]
        yield world, pilots, actions
        world.step([actions])


@pytest.mark.parametrize("explorer", ["frontier", "pso", "rrt", "pso-robots"])
def test_planners_for_plain_maps_explore_all_levels_one_after_the_other(explorer):
    *_, (world, _, _) = moves(LevelByLevel(explorer=explorer), TASK, 2)
    assert world.team_coverage[0] == 1.0
    assert not world.state.collisions.any()


def test_a_uav_changes_levels_only_where_no_frontier_of_its_level_is_in_reach():
    task, changes = TASK.with_settings({"team": 1}), 0
    for world, (pilot,), (action,) in moves(LevelByLevel(), task, 4):
        if action > Action.STAY:
            changes += 1
            view, levels = world.view(0, 0), world.briefing(0, 0).levels
            level, row, col = levels.voxel(view.cell)
            flat = pilot.seen_on(view, level)
            field = pilot._level_paths.field(flat.belief, (row, col))
            assert not (frontier_mask(np.ascontiguousarray(flat.belief)) & (field < flat.belief.size)).any()
            assert flat.belief[flat.cell] == FREE
    assert changes >= 2


def test_at_one_height_a_uav_stays_and_says_that_it_is_done():
    *_, (world, pilots, actions) = moves(LevelByLevel(stay=True), TASK, 2, steps=400)
    levels = world.briefing(0, 0).levels
    for n, pilot in enumerate(pilots):
        rows = np.flatnonzero(world.state.visited[0, n].any(axis=1))
        assert len({levels.voxel((row, 0))[0] for row in rows.tolist()}) == 1
        assert pilot.done
    assert actions == [Action.STAY, Action.STAY]


def test_on_plain_maps_it_is_the_other_policy():
    task = scenario("thesis-team-2").for_evaluation()
    flights = [[actions for *_, actions in moves(p, task, 5)] for p in (LevelByLevel(), make_policy("frontier"))]
    assert flights[0] == flights[1]


def test_teammates_on_other_levels_are_left_out():
    task = TASK.with_settings({"radio.model": "unlimited"})
    for world, pilots, _ in moves(LevelByLevel(), task, 6, steps=40):
        view, levels = world.view(0, 0), world.briefing(0, 0).levels
        level = levels.voxel(view.cell)[0]
        seen = pilots[0].seen_on(view, level).mates
        assert len(seen) == (levels.voxel(view.mates[0].cell)[0] == level if view.mates else 0)
