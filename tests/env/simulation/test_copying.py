"""Copies of worlds, made in the middle of an episode: the same future, and independent ones."""

import copy
import pickle

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError, World
from tests.env.worlds import random_actions

#: What the presets lack.
HARDER: dict[str, dict[str, object]] = {
    "failures": {"failures.hazard": 0.02, "failures.radio_hazard": 0.1, "failures.radio_outage": 4, "radio.loss": 0.3},
    "errors": {"noise.misses": 0.05, "drift.rate": 0.05, "base.at": "start", "lidar.field_of_view": 120.0},
    "prior": {"prior.kind": "outdated", "base.at": "start"},
    "plug-ins": {"lidar.model": "tests.env.plugins:exact", "radio.model": "tests.env.plugins:disc"},
}
WORLDS = PRESETS | {name: PRESETS["thesis-team-4"].with_settings(changed) for name, changed in HARDER.items()}
WAYS = (World.copy, copy.copy, copy.deepcopy, lambda world: pickle.loads(pickle.dumps(world)))


def read_only_arrays(world):
    """A world as protocol 5 of pickle gives it where arrays lie in shared memory."""
    buffers = []
    data = pickle.dumps(world, protocol=5, buffer_callback=buffers.append)
    return pickle.loads(data, buffers=[bytes(buffer.raw()) for buffer in buffers])


def arrays_of(world):
    return [*world.state, *(world.slam or ())]


def assert_same(one, other):
    for ours, theirs in zip(arrays_of(one), arrays_of(other), strict=True):
        np.testing.assert_array_equal(ours, theirs)
        assert not np.shares_memory(ours, theirs)


@pytest.mark.parametrize(("number", "name"), list(enumerate(WORLDS)), ids=str)
def test_a_copy_made_at_a_random_step_flies_on_bit_for_bit(number, name):
    rng, world = np.random.default_rng(number), World(WORLDS[name])
    world.reset([number])
    for _ in range(rng.integers(30)):
        world.step(random_actions(rng, world))
    world.post(0, 0, (1.0, 2.0))
    way = (*WAYS, read_only_arrays)[number % (1 + len(WAYS))]
    twin, kept = way(world), [array.copy() for array in arrays_of(world)]
    futures = []
    for each in (twin, world):
        if each is world:
            assert all(map(np.array_equal, kept, arrays_of(world)))
        rng = np.random.default_rng(5)
        for _ in range(20):
            each.step(random_actions(rng, each))
        futures.append([each.view(0, n) for n in range(each.scenario.team)])
        each.floorplan(0), each.prior(0)
    assert_same(twin, world)
    np.testing.assert_array_equal(twin.floorplan(0).truth, world.floorplan(0).truth)
    np.testing.assert_equal(*futures)
    np.testing.assert_equal(twin.prior(0), world.prior(0))
    assert not twin.view(0, 0).belief.flags.writeable
    for each in (twin, world):
        each.restart([0], [number + 1])
    assert_same(twin, world)


@pytest.mark.parametrize("way", WAYS)
def test_copies_have_all_that_a_world_has(way):
    world = World(PRESETS["thesis-team-2"], 40, threads=2)
    with pytest.raises(InputError, match="call reset first"):
        _ = way(world).state
    world.reset(range(40))
    world.restart([3], [77])
    twin = way(world)
    assert (twin.seeds, twin.begun.tolist(), twin.scenario) == (world.seeds, world.begun.tolist(), world.scenario)
    twin.restart([5], [99])
    assert world.seeds[5] == 5
    assert world.begun.sum() == 41
    assert world.floorplan(7).digest == twin.floorplan(7).digest
    assert not pickle.loads(pickle.dumps(world.floorplan(7))).truth.flags.writeable
    actions = np.full((40, 2), 3)
    world.restart([5], [99])
    twin.step(actions)
    world.step(actions)
    assert_same(twin, world)
