"""Planes kept up to date in place equal those painted anew from each view."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import World
from indoor_explorers.env.observations.incremental import LivePlanes
from indoor_explorers.env.observations.planes import PLANES, Channels
from tests.env.worlds import begun, floorplans, random_actions, scenarios


def painted(world, planes):
    """(B, N, C, H, W) planes encoded from the views one by one."""
    return np.array(
        [
            [
                Channels(planes=planes)(world.briefing(b, n)).observation(world.view(b, n))
                for n in range(world.scenario.team)
            ]
            for b in range(world.batch)
        ]
    )


@settings(max_examples=60, deadline=None)
@given(
    scenarios(),
    floorplans(),
    st.integers(0, 2**32),
    st.lists(st.sampled_from(PLANES), min_size=1, unique=True),
    st.data(),
)
def test_they_equal_planes_painted_anew(scenario, floorplan, seed, planes, data):
    world = begun(scenario, floorplan, seed)
    live, rng = LivePlanes(world, planes), np.random.default_rng(seed)
    for _ in range(25):
        deed = data.draw(st.sampled_from(["step", "step", "step", "two steps", "begin", "nothing"]))
        if deed == "begin":
            world.begin(0, int(rng.integers(100)), floorplan=floorplan)
        elif deed != "nothing":
            for _ in range(1 + (deed == "two steps")):
                world.step(random_actions(rng, world))
        np.testing.assert_array_equal(live.update(), painted(world, planes))
    assert live.planes is live.update()


@pytest.mark.parametrize("threads", [1, 2])
def test_a_batch_that_starts_anew_here_and_there(threads):
    from indoor_explorers.env import PRESETS

    world = World(PRESETS["thesis-team-2"].with_settings({"budget": 30}), 5, threads=threads)
    world.reset(range(5))
    live, rng = LivePlanes(world), np.random.default_rng(0)
    for seed in range(5, 120):
        live.step(rng.integers(0, 5, (5, 2)))
        over = np.flatnonzero(~world.flying.any(axis=1))
        world.restart(over, [seed + 1000 * k for k in range(len(over))])
        live.update()
    assert (world.begun > 2).all()
    np.testing.assert_array_equal(live.planes, painted(world, PLANES))
