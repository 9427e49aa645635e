"""Random worlds and flights for the tests."""

from typing import get_args

import numpy as np
from hypothesis import strategies as st

from indoor_explorers.env import Scenario, World
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.scenarios.codes import RadioModelName
from indoor_explorers.env.search.connected_parts import largest_part


@st.composite
def floorplans(draw, smallest=4, largest=12):
    """A random map whose largest free part holds at least a third of it."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    height, width = draw(st.integers(smallest, largest)), draw(st.integers(smallest, largest))
    truth = np.where(rng.random((height, width)) < draw(st.sampled_from([0.0, 0.15, 0.3])), OCCUPIED, FREE)
    if largest_part(truth == FREE).sum() * 3 < truth.size:
        truth[:] = FREE
    return Floorplan(truth.astype(np.uint8), "random")


@st.composite
def scenarios(draw, /, most=5, **fixed):
    """A random scenario without a map: team, sensing, radio, rules."""
    settings = {
        "team": draw(st.integers(1, most)),
        "lidar": {
            "range": draw(st.sampled_from([1.0, 1.5, 3.0, 5.0])),
            "model": draw(st.sampled_from(["exact", "exact", "marsexplorer"])),
        },
        "radio": {
            "model": draw(st.sampled_from(get_args(RadioModelName))),
            "range": draw(st.sampled_from([0.0, 1.0, 3.0, 6.0])),
            "loss": draw(st.sampled_from([0.0, 0.0, 0.3])),
        },
        "failures": draw(
            st.sampled_from([{}, {}, {"hazard": 0.05}, {"hazard": 0.1, "last_word": True, "reward": -3.0}])
        )
        | draw(st.sampled_from([{}, {}, {"radio_hazard": 0.2, "radio_outage": 3}])),
        "base": draw(
            st.sampled_from(
                [{}, {}, {"at": "start"}, {"at": "start", "radius": 0.0}, {"at": "start", "must_return": True}]
            )
        ),
        "on_collision": draw(st.sampled_from(["end", "block"])),
        "goal": draw(st.sampled_from([0.5, 0.9, 1.0])),
        "goal_of": draw(st.sampled_from(["agent", "team", "every"])),
        "stuck": {"rule": draw(st.sampled_from(["off", "no-discovery", "oscillation"])), "window": 10, "repeats": 5},
        "denominator": draw(st.sampled_from(["reachable", "map"])),
        "budget": draw(st.integers(1, 60)),
    }
    return Scenario(**(settings | fixed))


def begun(scenario, floorplan, seed):
    """A world of one episode."""
    world = World(scenario)
    world.begin(0, seed, floorplan=floorplan)
    return world


def random_actions(rng, world, careful=0.9):
    """(1, N) actions, most of them legal."""
    legal = world.state.legal[0]
    wild = rng.integers(0, 5, len(legal))
    tame = [rng.choice(np.flatnonzero(row)) for row in legal]
    return np.where(rng.random(len(legal)) < careful, tame, wild)[None]
