"""Batches of worlds in checkpoints."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World
from indoor_explorers.learners.sessions.worlds import restore_world, world_tensors

#: The arrays whose names checkpoints have had since before the state's names changed.
LASTING = {"journal", "read", "heard", "heard_step", "heard_cell", "heard_size"}


@pytest.mark.parametrize("errors", [{}, {"drift.rate": 0.1, "noise.misses": 0.1}], ids=["exact", "errors"])
def test_a_world_goes_on_from_the_names_that_checkpoints_have_always_had(errors):
    def flown(world, steps, rng):
        for _ in range(steps):
            world.step(rng.integers(0, 5, (2, 2)))

    scenario = PRESETS["thesis-team-2"].with_settings({"on_collision": "block"} | errors)
    worlds = [World(scenario, 2) for _ in range(2)]
    worlds[0].reset([3, 4])
    flown(worlds[0], 10, np.random.default_rng(0))
    tensors = {name: array.copy() for name, array in world_tensors(worlds[0]).items()}
    assert {f"world/{name}" for name in LASTING} <= tensors.keys()
    restore_world(tensors, worlds[1])
    for world in worlds:
        flown(world, 10, np.random.default_rng(1))
    for name, array in worlds[0].state._asdict().items():
        np.testing.assert_array_equal(array, getattr(worlds[1].state, name), err_msg=name)
