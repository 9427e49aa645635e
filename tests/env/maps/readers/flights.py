"""Flights in maps from files."""

from indoor_explorers.env import World, make_policy
from indoor_explorers.env.scenarios.presets import on_files


def flown(path, steps=60, **settings):
    """The share of a map that a UAV knows after some steps, in which it meets no obstacle."""
    world = World(on_files((str(path),), None).with_settings({"team": 1, **settings}))
    world.reset(seeds=[1])
    pilot = make_policy("frontier-nearest").pilot(world.briefing(0, 0))
    for _ in range(steps):
        if world.flying.any():
            world.step([[pilot.act(world.view(0, 0))]])
    return float(world.team_coverage[0])
