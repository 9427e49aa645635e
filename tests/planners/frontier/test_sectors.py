"""Sectors of teammates that were never heard, for planners that order clusters."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.learners.places.policy import DddqnPlaces
from indoor_explorers.planners.frontier.latency import FrontierLatency
from indoor_explorers.planners.toolbox.coordination.out_of_contact import OutOfContact


def cells_of(policy, radio, steps=40):
    """Return where four UAVs are after each step, (S, 4, 2)."""
    world = World(PRESETS["small-floors"].with_settings({"team": 4, "radio.model": radio}).for_evaluation())
    world.begin(0, 5)
    flown = []
    for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
        flown.append(world.state.cell[0].copy())
        if len(flown) == steps:
            break
    return np.array(flown)


@pytest.mark.parametrize("kind", [FrontierLatency, DddqnPlaces])
def test_teammates_that_are_heard_have_no_sectors(kind):
    assert np.array_equal(cells_of(kind(sector=3.0), "unlimited"), cells_of(kind(), "unlimited"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", [FrontierLatency, DddqnPlaces])
def test_sectors_part_the_uavs_without_a_radio(kind):
    def covered(policy):
        world = World(PRESETS["small-floors"].with_settings({"team": 4, "radio.model": "none"}).for_evaluation(), 4)
        for episode in range(4):
            world.begin(episode, episode)
        for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
            if world.state.step.max() == 100:
                break
        return float(world.team_coverage.mean())

    alike, apart = covered(kind()), covered(kind(sector=3.0))
    assert apart > 1.1 * alike


def test_factors_at_flat_cells_are_those_of_their_rows_and_columns():
    world = World(PRESETS["small-floors"].with_settings({"team": 4, "radio.model": "none"}).for_evaluation())
    world.begin(0, 5)
    view, cells = world.view(0, 1), np.array([7, 300, 1100], np.int32)
    points = np.stack(np.divmod(cells, view.belief.shape[1]), axis=1).astype(np.float64)
    own = OutOfContact(world.briefing(0, 1))
    factors = own.left_by_unheard_at_cells(view, cells)
    assert np.array_equal(factors, own.left_by_unheard(view, points))
    assert len(set(factors.tolist())) == 3
