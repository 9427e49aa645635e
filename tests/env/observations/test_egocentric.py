"""Crop, coarse map and status: what their numbers mean, on maps of any size."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import FREE, OCCUPIED, PRESETS, UNKNOWN, Mate, Scenario, View, World
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.observations import (
    BASE_STATUS,
    PLANES,
    STATUS,
    Coarse,
    Crop,
    Egocentric,
    Flat,
    Parts,
    Stacked,
    Status,
    make_encoder,
)
from tests.env.arrays import assert_same
from tests.env.worlds import begun, floorplans, random_actions, scenarios

seeds = st.integers(0, 2**32)
SIZES = ((2, 3), (8, 8), (16, 16), (9, 40), (60, 100))


def briefing(shape=(2, 3), team=3, agent=1):
    return begun(Scenario(team=team), Floorplan(np.full(shape, FREE), "room"), 0).briefing(0, agent)


def a_view(mates=()):
    belief = np.array([[FREE, FREE, UNKNOWN], [OCCUPIED, FREE, FREE]], np.uint8)
    return View(belief, (0, 0), np.array([0, 0, 0, 1, 1], bool), 4, 16, mates, visited=belief == OCCUPIED)


MATES = (Mate(0, (1, 1), 0, None), Mate(2, (1, 2), 51, (1.0,)))


def test_the_planes_of_a_crop():
    seen = make_encoder(Crop(side=3, planes=PLANES), briefing()).observation(a_view(MATES))
    assert dict(zip(PLANES, seen.tolist(), strict=True)) == {
        "unknown": [[0, 0, 0], [0, 0, 0], [0, 0, 0]],
        "free": [[0, 0, 0], [0, 1, 1], [0, 0, 1]],
        "obstacle": [[1, 1, 1], [1, 0, 0], [1, 1, 0]],
        "self": [[0, 0, 0], [0, 1, 0], [0, 0, 0]],
        "mates": [[0, 0, 0], [0, 0, 0], [0, 0, 1]],
        "visited": [[0, 0, 0], [0, 0, 0], [0, 1, 0]],
        "frontier": [[0, 0, 0], [0, 0, 1], [0, 0, 0]],
    }


@settings(max_examples=60, deadline=None)
@given(scenarios(), floorplans(), seeds, st.sampled_from([1, 3, 7, 31]))
def test_a_crop_is_the_planes_of_the_map_cut_out(scenario, floorplan, seed, side):
    world, rng = begun(scenario, floorplan, seed), np.random.default_rng(seed)
    for _ in range(6):
        world.step(random_actions(rng, world))
    view, brief = world.view(0, 0), world.briefing(0, 0)
    seen = make_encoder(Crop(side=side, planes=PLANES), brief).observation(view)
    half = side // 2
    for plane, whole, cut in zip(PLANES, make_encoder("channels", brief).observation(view), seen, strict=True):
        around = np.pad(whole, half, constant_values=255 * (plane == "obstacle"))
        wanted = around[view.cell[0] : view.cell[0] + side, view.cell[1] : view.cell[1] + side]
        assert np.allclose(cut, wanted / 255)


@settings(max_examples=60, deadline=None)
@given(scenarios(most=1), floorplans(), seeds, st.sampled_from([1, 2, 5, 12]), st.booleans())
def test_a_coarse_map_is_adaptive_average_pooling(scenario, floorplan, seed, zones, centred):
    """As torch does it; around the UAV, of the map padded to what holds it wherever the UAV is."""
    world, rng = begun(scenario, floorplan, seed), np.random.default_rng(seed)
    for _ in range(6):
        world.step(random_actions(rng, world))
    view, brief = world.view(0, 0), world.briefing(0, 0)
    names = ("unknown", "free", "obstacle", "visited", "frontier")
    seen = make_encoder(Coarse(zones=zones, planes=names, centred=centred), brief).observation(view)
    for plane, whole, pooled in zip(names, make_encoder("+".join(names), brief).observation(view), seen, strict=True):
        pads = [(n - 1 - at, at) if centred else (0, 0) for n, at in zip(whole.shape, view.cell, strict=True)]
        padded = np.pad(whole, pads, constant_values=255 * (plane == "obstacle")) / 255
        wanted = torch.nn.functional.adaptive_avg_pool2d(torch.from_numpy(padded)[None], zones)[0]
        assert np.allclose(pooled, wanted, atol=1e-6)


def test_a_coarse_map_marks_uavs_in_their_zones():
    own, mates = make_encoder(Coarse(zones=2, planes=("self", "mates"), centred=False), briefing((2, 3))).observation(
        a_view(MATES)
    )
    assert own.tolist() == [[1, 0], [0, 0]]
    assert np.allclose(mates, [[0, 0], [1, 1]])
    own, mates = make_encoder(Coarse(zones=5, planes=("self", "mates")), briefing()).observation(a_view(MATES))
    empty, middle = [0, 0, 0, 0, 0], [0, 0, 1, 0, 0]
    assert own.tolist() == [empty, middle, middle, middle, empty]
    assert np.allclose(mates, [empty, empty, empty, [0, 0, 0, 1, 0.8], [0, 0, 0, 1, 0.8]])


def test_the_numbers_of_a_status():
    seen = make_encoder(Status(), briefing()).observation(a_view(MATES))
    wanted = {"known": 5 / 6, "elapsed": 1 / 4, "number": 2 / 3, "linked": 1 / 2, "row": 1 / 4, "column": 1 / 6}
    wanted |= {"down": 0, "left": 0, "up": 0, "right": 1, "stay": 1}
    assert dict(zip(STATUS, seen.tolist(), strict=True)) == pytest.approx(wanted)
    assert make_encoder(Status(), briefing(team=1, agent=0)).observation(a_view())[:4] == pytest.approx(
        [5 / 6, 0.25, 1, 0]
    )


def test_a_status_with_the_base_tells_where_it_is_and_how_old_the_last_contact():
    brief = replace(briefing(), base=(1, 2))
    encoder = make_encoder(Status(base=True), brief)

    def told(view):
        seen = encoder.observation(view)
        assert encoder.space.contains(seen)
        assert np.array_equal(seen[: len(STATUS)], make_encoder(Status(), brief).observation(view))
        return dict(zip(BASE_STATUS, seen[len(STATUS) :].tolist(), strict=True))

    here = {"base": 1, "base_down": 0.5 + 1 / 4, "base_right": 0.5 + 2 / 6}
    assert told(a_view(MATES)) == pytest.approx(here | {"base_age": 1})
    assert told(a_view(MATES)._replace(base_age=4)) == pytest.approx(here | {"base_age": 4 / 16})
    encoder.reset()
    assert told(a_view(MATES)._replace(base_age=0))["base_right"] == pytest.approx(0.5 + 2 / 6)
    encoder.begin(replace(brief, base=(0, 0)))
    assert told(a_view(MATES)._replace(base_age=0)) == {"base": 1, "base_down": 0.5, "base_right": 0.5, "base_age": 0}
    encoder.begin(replace(brief, base=None))
    assert set(told(a_view(MATES)).values()) == {0}


def test_whatever_holds_a_status_passes_on_where_the_base_is():
    """Episodes of one environment have bases in different cells."""
    for factory in (Parts({"a": Status(base=True)}), Flat(Egocentric(base=True)), Stacked(Egocentric(base=True), 2)):
        one, other = (replace(briefing(), base=base) for base in ((0, 1), (1, 2)))
        encoder = make_encoder(factory, one)
        assert not encoder.stateless
        first = encoder.observation(a_view())
        encoder.begin(other)
        assert_same(encoder.observation(a_view()), make_encoder(factory, other).observation(a_view()))
        encoder.begin(one)
        assert_same(encoder.observation(a_view()), first)
    assert make_encoder(Flat(Egocentric()), briefing()).stateless


@pytest.mark.parametrize(
    "factory",
    [Egocentric(), Egocentric(side=5, zones=20, centred=False), Flat(Egocentric()), Egocentric(base=True)],
)
def test_the_shapes_are_the_same_on_maps_of_any_size_and_for_any_team(factory):
    """So that one network reads them all."""
    spaces = [make_encoder(factory, briefing(shape)).space for shape in SIZES]
    spaces += [make_encoder(factory, briefing((16, 16), team=team, agent=0)).space for team in (1, 8)]
    assert all(space == spaces[0] for space in spaces)


def test_a_large_map_fills_the_space_too():
    world = World(PRESETS["office"])
    world.reset([1])
    encoder = make_encoder("egocentric", world.briefing(0, 1))
    assert encoder.space.contains(encoder.observation(world.view(0, 1)))
    assert {name: box.shape for name, box in encoder.space.items()} == {
        "coarse": (3, 12, 12),
        "crop": (5, 15, 15),
        "status": (11,),
    }
