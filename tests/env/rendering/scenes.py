"""Scenes for the tests, and where things are in their pictures."""

import dataclasses

import numpy as np

from indoor_explorers.env import World, scenario
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.rendering import Trails, paint, scene_of
from indoor_explorers.env.rendering.layout import TITLE, layout_of
from indoor_explorers.env.search.connected_parts import largest_part
from tests.env.worlds import random_actions


def flown(steps=12, seed=0, floorplan=None, **settings):
    """A world, and the trails of its episode, after some careful steps."""
    task = scenario("thesis-team-4").for_evaluation().with_settings({"on_collision": "block"} | settings)
    world, rng = World(task), np.random.default_rng(seed)
    world.begin(0, seed, floorplan=floorplan)
    trails = Trails(world.state.truth.shape[1:])
    trails.restart(world.state.cell[0])
    for _ in range(steps):
        world.step(random_actions(rng, world, careful=1.0))
        trails.add(world.state.cell[0])
    return world, trails


def scene(**arguments):
    """A scene whose arrays are its own."""
    world, trails = flown(**arguments)
    return copied(scene_of(world, 0, trails))


def copied(one, **changes):
    """A copy of a scene that shares no arrays, with some fields replaced."""
    fields = {field.name: getattr(one, field.name) for field in dataclasses.fields(one)}
    arrays = {name: value.copy() for name, value in fields.items() if isinstance(value, np.ndarray)}
    return dataclasses.replace(one, **(arrays | changes))


def plan(free):
    """A floorplan from a mask of free cells."""
    return Floorplan(np.where(free, FREE, OCCUPIED).astype(np.uint8), "test")


def random_plan(shape, seed=0, walls=0.2):
    """A map of random obstacles, of which only the largest free part is left."""
    return plan(largest_part(np.random.default_rng(seed).random(shape) >= walls))


def main_map(one):
    """The pixels of the team's map."""
    return cut(paint(one), layout_of(one.shape, one.team).main)


def panel(one, agent, titled=True):
    """The pixels of a UAV's own map, with its title above."""
    box = layout_of(one.shape, one.team).panels[agent]
    above = TITLE if titled else 0
    return cut(paint(one), box._replace(top=box.top - above, height=box.height + above))


def cut(picture, box):
    return picture[box.top : box.top + box.height, box.left : box.left + box.width]


def pixel(picture, shape, cell, towards=(0.0, 0.0)):
    """The pixel at the middle of a cell, or some cells (rows, columns) from it."""
    size = picture.shape[0] / shape[0], picture.shape[1] / shape[1]
    row, col = ((cell[k] + 0.5 + towards[k]) * size[k] for k in (0, 1))
    return picture[int(row), int(col)].astype(int)
