"""Encoders: what their numbers mean, and that they come from one UAV's view alone."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import FREE, OCCUPIED, PRESETS, UNKNOWN, InputError, Mate, Scenario, View, World
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.observations import (
    PLANES,
    Channels,
    Coarse,
    Crop,
    Egocentric,
    Encoder,
    Flat,
    Masked,
    Parts,
    Stacked,
    Views,
    make_encoder,
)
from indoor_explorers.env.observations.base import empty, row_of
from indoor_explorers.env.observations.factories import BatchedEncoder
from indoor_explorers.env.search.frontiers import frontier_mask
from tests.env.arrays import assert_same, filled
from tests.env.worlds import begun, floorplans, random_actions, scenarios

#: One of each kind, and of each kind of combination.
OBSERVATIONS = (
    "channels",
    "thesis",
    "mates+self",
    *PLANES,
    "egocentric",
    "egocentric-flat",
    Crop(side=3, planes=PLANES),
    Coarse(zones=5, planes=PLANES),
    Coarse(zones=4, planes=PLANES, centred=False),
    Masked("thesis"),
    Masked("egocentric"),
    Flat(Masked("channels")),
    Stacked("channels", 3),
    Stacked("egocentric", 2),
    Flat(Parts({"image": Stacked("thesis", 2), "around": "egocentric"})),
)
each_observation = pytest.mark.parametrize("observation", OBSERVATIONS, ids=str)
seeds = st.integers(0, 2**32)


def briefing(team=3, agent=1):
    world = begun(Scenario(team=team), Floorplan(np.full((2, 3), FREE), "room"), 0)
    return world.briefing(0, agent)


def a_view(mates=()):
    belief = np.array([[FREE, FREE, UNKNOWN], [OCCUPIED, FREE, FREE]], np.uint8)
    return View(belief, (0, 0), np.ones(5, np.bool_), step=4, budget=9, mates=mates, visited=belief == OCCUPIED)


MATES = (Mate(0, (1, 1), 0, None), Mate(2, (1, 2), 7, (1.0,)))


def test_the_planes_of_channels():
    image = dict(zip(PLANES, make_encoder("channels", briefing()).observation(a_view(MATES)).tolist(), strict=True))
    assert image == {
        "unknown": [[0, 0, 255], [0, 0, 0]],
        "free": [[255, 255, 0], [0, 255, 255]],
        "obstacle": [[0, 0, 0], [255, 0, 0]],
        "self": [[255, 0, 0], [0, 0, 0]],
        "mates": [[0, 0, 0], [0, 255, 248]],
        "visited": [[0, 0, 0], [255, 0, 0]],
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
    assert np.array_equal(some.observation(view), whole[[6, 1, 4]])


def test_a_function_serves_in_place_of_a_name():
    encoder = make_encoder(lambda brief: make_encoder("free", brief), briefing())
    assert isinstance(encoder, Encoder)
    assert encoder.space.shape == (1, 2, 3)


@pytest.mark.parametrize(
    ("make", "hint"),
    [
        *[
            (lambda name=name: make_encoder(name, briefing()), hint)
            for name, hint in (
                ("chanels", "did you mean 'channels'"),
                ("egocentrc", "did you mean 'egocentric'"),
                ("free+fronteir", "did you mean 'frontier'"),
                ("zzz", "known: "),
                (None, "a name, or a factory of an Encoder"),
                (lambda brief: 3, "a name, or a factory of an Encoder"),
                (Flat("thesi"), "did you mean 'thesis'"),
            )
        ],
        (lambda: Channels(planes=()), "a sequence of planes"),
        (lambda: Channels(planes="free"), "a sequence of planes"),
        (lambda: Crop(planes=("fre",)), "did you mean 'free'"),
        (lambda: Crop(side=14), "side to be an odd number"),
        (lambda: Egocentric(side=0), "side to be an odd number"),
        (lambda: Egocentric(zones=0), "zones"),
        (lambda: Stacked("free", 0), "depth"),
        (lambda: Parts({}), "a mapping of names"),
        (lambda: Stacked(Masked("free"), 2)(briefing()), r"use Masked\(Stacked"),
        (lambda: Parts({"a": "egocentric", "crop": "free"})(briefing()), "two parts called 'crop'"),
    ],
)
def test_what_no_encoder_can_be_made_of_is_refused(make, hint):
    with pytest.raises(InputError, match=hint):
        make()


@each_observation
def test_observations_are_chosen_by_plain_data(observation):
    assert pickle.loads(pickle.dumps(observation)) == observation


@settings(max_examples=100, deadline=None)
@given(scenarios(), floorplans(), seeds, st.sampled_from(OBSERVATIONS))
def test_observations_are_in_their_space_and_overwrite_all_of_out(scenario, floorplan, seed, observation):
    world, rng = begun(scenario, floorplan, seed), np.random.default_rng(seed)
    encoders = [make_encoder(observation, world.briefing(0, n)) for n in range(scenario.team)]
    for _ in range(10):
        world.step(random_actions(rng, world))
        for n, encoder in enumerate(encoders):
            view, space = world.view(0, n), encoder.space
            seen, dirty = encoder.observation(view), filled(empty(space), 77)
            encoder.encode(view, dirty)
            assert space.contains(seen)
            assert_same(dirty, seen)
            assert encoder.space is space


@settings(max_examples=30, deadline=None)
@given(scenarios(), floorplans(), seeds)
def test_the_frontier_plane_is_the_frontier(scenario, floorplan, seed):
    view = begun(scenario, floorplan, seed).view(0, 0)
    plane = make_encoder("frontier", begun(scenario, floorplan, seed).briefing(0, 0)).observation(view)[0]
    assert np.array_equal(plane == 255, frontier_mask(view.belief))


@each_observation
def test_a_batch_is_encoded_as_each_of_its_views(observation):
    world, rng = (
        World(PRESETS["thesis-obstacles"].with_settings({"on_collision": "block"}), 5),
        np.random.default_rng(0),
    )
    world.reset(range(5))
    state, briefing = world.state, world.briefing(0, 0)
    batched = BatchedEncoder(observation, briefing, 5)
    encoders = [make_encoder(observation, briefing) for _ in range(5)]
    for _ in range(6):
        out = filled(empty(batched.space, 5), 77)
        alone = (array[:, 0] for array in (state.belief, state.cell, state.legal))
        batched.encode(Views(*alone, state.step, state.budget, state.visited[:, 0]), out)
        for b, encoder in enumerate(encoders):
            assert_same(row_of(out, b), encoder.observation(world.view(b, 0)))
        world.step(rng.integers(0, 5, (5, 1)))


@settings(max_examples=60, deadline=None)
@given(scenarios(most=1, spawn=((0, 0),), goal=1.0, denominator="map"), floorplans(6, 14), seeds)
def test_what_is_too_far_to_be_seen_never_changes_an_observation(scenario, floorplan, seed):
    """Fly twice with the same actions, the second time with every cell out of lidar range turned over."""
    truth = floorplan.truth.copy()
    truth[0, 0] = FREE
    actions, cells = flight(scenario, truth, seed)
    rows, cols = np.indices(truth.shape)
    far = np.all([np.hypot(rows - r, cols - c) > scenario.lidar.range + 1 for r, c in cells], axis=0)
    other = np.where(far, FREE + OCCUPIED - truth, truth).astype(np.uint8)
    assert_same(*(seen_on(scenario, room, seed, actions) for room in (truth, other)))


def flight(scenario, truth, seed):
    """Return random actions, and the cells that they lead to."""
    world, rng = begun(scenario, Floorplan(truth, "one"), seed), np.random.default_rng(seed)
    actions, cells = [], [(0, 0)]
    while len(actions) < 6 and world.flying.any():
        actions.append(random_actions(rng, world, careful=1.0))
        world.step(actions[-1])
        cells.append(world.view(0, 0).cell)
    return actions, cells


def seen_on(scenario, truth, seed, actions):
    """Return what every encoder shows along a flight, each asked once a step."""
    world = begun(scenario, Floorplan(truth, "room"), seed)
    encoders = {str(each): make_encoder(each, world.briefing(0, 0)) for each in OBSERVATIONS}
    seen = {}
    for step in range(len(actions) + 1):
        for name, encoder in encoders.items():
            seen[f"{step} {name}"] = encoder.observation(world.view(0, 0))
        if step < len(actions):
            world.step(actions[step])
    return seen


@settings(max_examples=40, deadline=None)
@given(scenarios(), floorplans(), seeds)
def test_only_the_view_and_the_briefing_decide(scenario, floorplan, seed):
    """Whatever else a world holds may change: encoders show a copied view as they show the world's own."""
    world, rng = begun(scenario, floorplan, seed), np.random.default_rng(seed)
    for _ in range(4):
        world.step(random_actions(rng, world))
    view, briefing = world.view(0, 0), world.briefing(0, 0)
    copy = view._replace(belief=view.belief.copy(), legal=view.legal.copy(), visited=view.visited.copy())
    before = [make_encoder(each, briefing).observation(view) for each in OBSERVATIONS]
    world.begin(0, seed + 1, floorplan=Floorplan(np.full(floorplan.shape, FREE), "other"), spawns=None)
    for each, seen in zip(OBSERVATIONS, before, strict=True):
        assert_same(make_encoder(each, briefing).observation(copy), seen)
