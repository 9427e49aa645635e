"""Scenarios with errors, maps and actions for tests."""

import numpy as np

from indoor_explorers.env import Scenario, World
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.search.connected_parts import largest_part

#: Each switch alone, strong enough for a short flight.
SWITCHES = {
    "misses": {"noise.misses": 0.2},
    "false returns": {"noise.false_returns": 0.08},
    "range errors": {"noise.range_std": 0.8},
    "field of view": {"lidar.field_of_view": 90.0},
    "drift": {"drift.rate": 0.3, "drift.closure_gap": 4},
    "rare closures": {"drift.rate": 0.4, "drift.closure_gap": 3, "drift.closures": 0.4, "drift.mates": False},
    "drift alone": {"drift.rate": 0.5, "drift.closures": 0.0, "drift.mates": False},
}
#: All switches together.
EVERYTHING = {
    **{"noise.misses": 0.1, "noise.false_returns": 0.03, "noise.range_std": 0.5, "lidar.field_of_view": 120.0},
    **{"drift.rate": 0.3, "drift.closure_gap": 4},
}
#: Errors that never happen, with which the world keeps maps of log-odds.
NEVER = {"noise.misses": 1e-300, "noise.false_returns": 1e-300, "drift.rate": 1e-300}


def task(team, *changes):
    """A task without a map that goes on to the budget, with changes of its settings."""
    quiet = {"lidar.range": 3.0, "on_collision": "block", "goal": 1.0, "goal_of": "team", "budget": 60}
    settings = {key: value for change in changes for key, value in change.items()}
    return Scenario(team=team).with_settings(quiet | settings)


def disc(reach, loss=0.0):
    """Settings of a radio."""
    return {"radio.model": "disc", "radio.range": reach, "radio.loss": loss}


def random_plan(seed, shape=(8, 10), obstacles=0.2):
    """A random map most of which can be reached."""
    rng = np.random.default_rng(seed)
    while True:
        truth = np.where(rng.random(shape) < obstacles, OCCUPIED, FREE).astype(np.uint8)
        if largest_part(truth == FREE).sum() * 2 > truth.size:
            return Floorplan(truth, "random")


def begun(scenario, seed, plan=None):
    """A world of one episode."""
    world = World(scenario)
    world.begin(0, seed, floorplan=plan or random_plan(seed))
    return world


def random_actions(rng, world, careful=0.8):
    """(N,) actions, most of them legal ones."""
    legal, count = world.state.legal[0], world.scenario.actions
    wild = rng.integers(0, count, len(legal))
    moves = [rng.choice(np.flatnonzero(row)) for row in legal]
    return np.where(rng.random(len(legal)) < careful, moves, wild)
