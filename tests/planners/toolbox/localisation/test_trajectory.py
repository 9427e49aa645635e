"""A UAV's estimate of its path, against the world's own books: where the map has each scan, and where it was made."""

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.planners.toolbox.localisation.trajectory import Trajectory

STEPS = 250


def flown(seed, rate):
    """The world after a flight of `frontier-nearest`, and what was estimated on the way."""
    world = World(scenario("small-floors").for_evaluation().with_settings({"team": 1, "drift.rate": rate}))
    world.reset([seed])
    pilot: Pilot = make_policy("frontier-nearest").pilot(world.briefing(0, 0))
    path = Trajectory(world.briefing(0, 0), 0.5)
    while world.flying.any() and len(path) < STEPS:
        view = world.view(0, 0)
        path.observe(view)
        action = pilot.act(view)
        path.expect(action)
        world.step([[action]])
    return world, path


def cells(flat, width):
    return np.stack(np.divmod(flat, width), axis=1)


@pytest.mark.parametrize("seed", range(4))
def test_it_knows_where_the_map_has_its_scans_and_nearly_always_where_they_were_made(seed):
    world, path = flown(seed, 0.01)
    width = world.state.truth.shape[2]
    drawn = cells(world.slam.drawn_at[0, 0, 0, : len(path)], width)
    true = cells(world.slam.true_cell[0, 0, : len(path)], width)
    assert (path.drawn[: len(path)] == drawn).all(axis=1).mean() > 0.95
    assert np.allclose(path.variance[: len(path)], world.slam.variance[0, 0, : len(path)], atol=1e-3)
    by_map, own = (drawn != true).any(axis=1).mean(), (path.places[: len(path)] != true).any(axis=1).mean()
    assert own <= by_map + 0.02


def test_over_flights_it_is_right_far_more_often_than_the_map():
    wrong = []
    for seed in range(8):
        world, path = flown(seed, 0.005)
        width = world.state.truth.shape[2]
        true = cells(world.slam.true_cell[0, 0, : len(path)], width)
        wrong.append([(each[: len(path)] != true).any(axis=1).mean() for each in (path.drawn, path.places)])
    by_map, own = np.mean(wrong, axis=0)
    assert by_map > 0.02
    assert own < 0.5 * by_map


def test_without_slips_none_is_found():
    _, path = flown(1, 1e-6)
    assert path.slips == 0
    assert not path.errors.any()
    assert path.error == (0, 0)
