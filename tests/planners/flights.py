"""Maps and flights for the planners' tests."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Mate, Policy, View, World, scenario
from indoor_explorers.env.grid.arrays import Cell, Mask
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.simulation.rollout import Uav, ask_pilots, make_pilots, rollout


@dataclass
class Flight:
    """One flown episode."""

    complete: bool
    steps: int
    tracks: list[list[Cell]]
    actions: list[list[int]]
    world: World
    pilots: Sequence[Any]

    @property
    def longest_dither(self) -> int:
        """The most steps in a row that any UAV spent on going A-B-A-B."""
        longest = 0
        for track in self.tracks:
            run = 0
            for before, between, now in zip(track, track[1:], track[2:], strict=False):
                run = run + 1 if before == now != between else 0
                longest = max(longest, run)
        return longest


def fly(
    policy: Policy,
    free: Mask,
    *,
    team: int = 1,
    radio: tuple[str, float] = ("none", 0.0),
    lidar: float = 3.0,
    seed: int = 0,
    budget: int = 5000,
    spawns: Sequence[Cell] | None = None,
    goal_of: str = "team",
    ends: dict[int, int] | None = None,
) -> Flight:
    """Fly an episode to full coverage or the budget; ``ends`` maps agents to the step at which they drop out."""
    settings = {
        "team": team,
        "radio.model": radio[0],
        "radio.range": radio[1],
        "lidar.range": lidar,
        "budget": budget,
    }
    task = scenario("thesis-open").with_settings(settings).for_evaluation().with_settings({"goal_of": goal_of})
    world = World(task)
    world.begin(0, seed, floorplan=Floorplan.from_free(free, "test"), spawns=spawns)
    pilots = make_pilots(policy, world)
    tracks: list[list[Cell]] = [[] for _ in range(team)]
    actions: list[list[int]] = []
    asks = ask_pilots(policy, pilots, world)

    def ask(flying: list[Uav]) -> Iterator[tuple[Uav, int]]:
        for _, k in flying:
            tracks[k].append(world.view(0, k).cell)
        for uav, action in asks(flying):
            message = pilots[uav].message
            assert message is None or all(np.isfinite(message))
            yield uav, action

    _end(world, ends)
    for chosen in rollout(world, ask):
        actions.append(chosen[0].tolist())
        _end(world, ends)
    assert world.state.collisions.sum() == 0
    complete, steps = world.team_coverage[0] >= 1.0, int(world.state.step[0])
    return Flight(complete, steps, tracks, actions, world, list(pilots.values()))


def world_on(free: Mask, spawns: Sequence[Cell] | None = None, seed: int = 0, **settings: Any) -> World:
    """A world at the start of an episode on a map; a setting's dot is written as two underscores."""
    named = {key.replace("__", "."): value for key, value in settings.items()}
    world = World(scenario("thesis-open").with_settings(named))
    world.begin(0, seed, floorplan=Floorplan.from_free(free, "test"), spawns=spawns)
    return world


def view_of(belief: np.ndarray, cell: Cell, mates: tuple[Mate, ...] = (), step: int = 100) -> View:
    """What a UAV in a cell knows: a map of which it has visited nothing, and its teammates."""
    return View(belief, cell, np.ones(5, np.bool_), step, 400, mates, np.zeros(belief.shape, np.bool_))


def graph_of(passable: Mask) -> nx.Graph[Cell]:
    """The graph of the cells of a mask, each joined to its neighbours, by networkx."""
    graph: nx.Graph[Cell] = nx.grid_2d_graph(*passable.shape)
    graph.remove_nodes_from([(row, col) for row, col in np.argwhere(~passable).tolist()])
    return graph


def _end(world: World, ends: dict[int, int] | None) -> None:
    for agent, step in (ends or {}).items():
        if world.state.step[0] >= step:
            world.state.end[0, agent] = 2


def maze(rows: int, cols: int, seed: int) -> Mask:
    """A maze of 1-wide corridors with dead ends and no loops, (2 rows + 1, 2 cols + 1)."""
    rng = np.random.default_rng(seed)
    free = np.zeros((2 * rows + 1, 2 * cols + 1), np.bool_)
    free[1, 1] = True
    stack = [(0, 0)]
    while stack:
        row, col = stack[-1]
        around = [(row + 1, col), (row - 1, col), (row, col + 1), (row, col - 1)]
        new = [(r, c) for r, c in around if 0 <= r < rows and 0 <= c < cols and not free[2 * r + 1, 2 * c + 1]]
        if not new:
            stack.pop()
            continue
        r, c = new[rng.integers(len(new))]
        free[2 * r + 1, 2 * c + 1] = free[row + r + 1, col + c + 1] = True
        stack.append((r, c))
    return free


def rooms(side: int, size: int, seed: int) -> Mask:
    """A square of ``side`` x ``side`` rooms joined by 1-wide corridors of three cells."""
    rng = np.random.default_rng(seed)
    pitch = size + 3
    free = np.zeros((side * pitch + 1, side * pitch + 1), np.bool_)
    for row in range(1, side * pitch, pitch):
        for col in range(1, side * pitch, pitch):
            free[row : row + size, col : col + size] = True
            door = int(rng.integers(size))
            if row + pitch < len(free) - 1:
                free[row + size : row + pitch, col + door] = True
            if col + pitch < len(free) - 1:
                free[row + door, col + size : col + pitch] = True
    return free


def fly_preset(policy: Policy, name: str, seed: int, **settings: Any) -> tuple[World, Any, NDArray[np.int64]]:
    """Return the world after an episode of a preset, its pilots, and the cells of all UAVs at each step."""
    world = World(scenario(name).for_evaluation().with_settings({"team": 1} | settings))
    world.reset([seed])
    pilots = make_pilots(policy, world)
    cells = [world.state.cell[0].copy()]
    for _ in rollout(world, ask_pilots(policy, pilots, world)):
        cells.append(world.state.cell[0].copy())
    return world, pilots, np.array(cells)
