"""Where flights over levels lose steps, and a planner that knows the map some steps ahead."""

import numpy as np
import pytest

from indoor_explorers.env import World, scenario
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.levels import Levels, plane_of
from indoor_explorers.evaluation.site.studies.level_losses import Foresight, foreseen, losses
from tests.planners.flights import fly_preset

CORRIDOR = plane_of(np.full((2, 1, 6), FREE, np.uint8))


def test_a_map_is_foreseen_along_free_cells_of_all_levels():
    truth, belief = CORRIDOR.copy(), np.full_like(CORRIDOR, UNKNOWN)
    truth[0, 3] = OCCUPIED
    belief[0, 0] = FREE
    levels = Levels.of(truth.shape, 2)
    cells = levels.volume(foreseen(truth, belief, levels, 3))
    assert cells[0, 0].tolist() == [FREE] * 3 + [OCCUPIED] * 3
    assert cells[1, 0].tolist() == [FREE] * 3 + [OCCUPIED] * 3
    whole = levels.volume(foreseen(truth, belief, levels, 20))
    np.testing.assert_array_equal(whole == FREE, levels.volume(truth) == FREE)


def test_losses_are_steps_without_new_cells_before_the_last_share():
    curve = np.array([0.2, 0.5, 0.5, 0.8, 0.92, *[0.92] * 10, 0.96, 1.0, 1.0])
    assert losses(curve) == [1, 3, 4, 15, 16, 11, 10, 10]
    assert losses(curve[:6]) == [1, 3, 4, 6, 6, 2, 0, 0]


def test_foresight_explores_all_and_farther_is_not_slower():
    near, far = (fly_preset(Foresight(ahead=ahead, changes=2000), "small-storeys", 3)[0] for ahead in (1, 50))
    assert near.team_coverage[0] == far.team_coverage[0] == 1.0
    assert far.state.step[0] < near.state.step[0]


def test_foresight_is_for_one_uav():
    world = World(scenario("small-storeys").with_settings({"team": 2}))
    world.reset(seeds=[1])
    with pytest.raises(InputError, match="expected one UAV"):
        Foresight().pilot(world.briefing(0, 0, privileged=True))
