"""Encoders: what their numbers mean, and that they come from one UAV's view alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import FREE, OCCUPIED, PRESETS, UNKNOWN, InputError, Mate, Scenario, View, World
from indoor_explorers.env.encoders import PLANES, BatchEncoder, Channels, make_encoder
from indoor_explorers.env.grid import frontier_mask
from indoor_explorers.env.maps.floorplan import Floorplan

from .worlds import begun, floorplans, random_actions, scenarios

NAMES = ("channels", "thesis", "mates+self", *PLANES)
seeds = st.integers(0, 2**32)


def briefing(team=3, agent=1):
    world = begun(Scenario(team=team), Floorplan(np.full((2, 3), FREE), "room"), 0)
    return world.briefing(0, agent)


def a_view(mates=()):
    belief = np.array([[FREE, FREE, UNKNOWN], [OCCUPIED, FREE, FREE]], np.uint8)
    return View(belief, (0, 0), np.ones(5, np.bool_), step=4, budget=9, mates=mates, visited=belief == 9)


MATES = (Mate(0, (1, 1), 0, None), Mate(2, (1, 2), 7, (1.0,)))


def test_the_planes_of_channels():
    image = dict(zip(PLANES, make_encoder("channels", briefing()).observation(a_view(MATES)).tolist(), strict=True))
    assert image == {
        "unknown": [[0, 0, 255], [0, 0, 0]],
        "free": [[255, 255, 0], [0, 255, 255]],
        "obstacle": [[0, 0, 0], [255, 0, 0]],
        "self": [[255, 0, 0], [0, 0, 0]],
        "mates": [[0, 0, 0], [0, 255, 248]],
        "frontier": [[0, 255, 0], [0, 0, 255]],
    }


def test_old_news_fades_but_never_vanishes_and_the_freshest_wins():
    encoder = make_encoder("mates", briefing())
    news = (Mate(0, (0, 1), 3000, None), Mate(1, (1, 1), 9, None), Mate(2, (1, 1), 200, None))
    assert encoder.observation(a_view(news)).tolist() == [[[0, 1, 0], [0, 246, 0]]]


def test_the_image_of_the_thesis():
    image = make_encoder("thesis", briefing()).observation(a_view(MATES))
    assert np.array_equal(image, np.array([[2, 0.3, 0], [0.5, 1, 3]], np.float32))


def test_a_uav_paints_itself_over_old_news_of_mates():
    image = make_encoder("thesis", briefing()).observation(a_view((Mate(2, (0, 0), 5, None),)))
    assert image[0, 0] == 2


def test_planes_are_composed_in_the_order_asked_for():
    whole, view = make_encoder("channels", briefing()).observation(a_view(MATES)), a_view(MATES)
    some = make_encoder("frontier+free+mates", briefing())
    assert some.space.shape == (3, 2, 3)
    assert np.array_equal(some.observation(view), whole[[5, 1, 4]])


def test_a_function_serves_in_place_of_a_name():
    assert isinstance(make_encoder(lambda brief: Channels(brief, ["free"]), briefing()), Channels)


@pytest.mark.parametrize(
    ("name", "hint"),
    [("chanels", "did you mean 'channels'"), ("free+fronteir", "did you mean 'frontier'"), ("zzz", "known: ")],
)
def test_an_unknown_name_is_refused_with_a_hint(name, hint):
    with pytest.raises(InputError, match=hint):
        make_encoder(name, briefing())


@settings(max_examples=30, deadline=None)
@given(scenarios(), floorplans(), seeds, st.sampled_from(NAMES))
def test_observations_are_in_their_space_and_overwrite_all_of_out(scenario, floorplan, seed, name):
    world, rng = begun(scenario, floorplan, seed), np.random.default_rng(seed)
    encoders = [make_encoder(name, world.briefing(0, n)) for n in range(scenario.team)]
    for _ in range(10):
        world.step(random_actions(rng, world))
        for n, encoder in enumerate(encoders):
            view = world.view(0, n)
            image = encoder.observation(view)
            dirty = np.full(image.shape, 77, image.dtype)
            encoder.encode(view, dirty)
            assert encoder.space.contains(image)
            assert np.array_equal(dirty, image)


@settings(max_examples=30, deadline=None)
@given(scenarios(), floorplans(), seeds)
def test_the_frontier_plane_is_the_frontier(scenario, floorplan, seed):
    view = begun(scenario, floorplan, seed).view(0, 0)
    plane = Channels(begun(scenario, floorplan, seed).briefing(0, 0), ["frontier"]).observation(view)[0]
    assert np.array_equal(plane == 255, frontier_mask(view.belief))


@pytest.mark.parametrize("name", NAMES)
def test_a_batch_is_encoded_as_each_of_its_views(name):
    world = World(PRESETS["thesis-obstacles"], 5)
    world.reset(range(5))
    encoder = make_encoder(name, world.briefing(0, 0))
    assert isinstance(encoder, BatchEncoder)
    out = np.full((5, *encoder.space.shape), 77, encoder.space.dtype)
    encoder.encode_batch(world.state.belief[:, 0], world.state.cell[:, 0], out)
    assert np.array_equal(out, [encoder.observation(world.view(b, 0)) for b in range(5)])


@settings(max_examples=60, deadline=None)
@given(scenarios(most=1, spawn=((0, 0),), goal=1.0, denominator="map"), floorplans(6, 14), seeds)
def test_what_is_too_far_to_be_seen_never_changes_an_observation(scenario, floorplan, seed):
    """Fly twice with the same actions, the second time with every cell out of lidar range turned over."""
    truth = floorplan.truth.copy()
    truth[0, 0] = FREE
    world, rng = begun(scenario, Floorplan(truth, "one"), seed), np.random.default_rng(seed)
    actions, cells = [], [(0, 0)]
    while len(actions) < 6 and world.flying.any():
        actions.append(random_actions(rng, world, careful=1.0))
        world.step(actions[-1])
        cells.append(world.view(0, 0).cell)
    rows, cols = np.indices(truth.shape)
    far = np.all([np.hypot(rows - r, cols - c) > scenario.lidar.range + 1 for r, c in cells], axis=0)
    other = begun(scenario, Floorplan(np.where(far, FREE + OCCUPIED - truth, truth).astype(np.uint8), "two"), seed)
    for chosen in actions:
        other.step(chosen)
    for name in NAMES:
        encoder = make_encoder(name, world.briefing(0, 0))
        assert np.array_equal(encoder.observation(world.view(0, 0)), encoder.observation(other.view(0, 0)))
