"""What an episode's seed draws before anybody moves: the map and the spawns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.grid.randomness import Stream, stream_key
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.reset import MAX_ATTEMPTS, is_attainable, new_ground, place_team
from indoor_explorers.env.simulation.state import rules_of


def draw_floorplan(scenario: Scenario, seed: int, index: int = 0) -> Floorplan:
    """Return the map of an episode seed, drawn again when the goal could not be reached on it."""
    rules = rules_of(scenario)
    for attempt in range(MAX_ATTEMPTS if scenario.map.generated else 1):
        floorplan = scenario.map.floorplan(index, seed, attempt)
        main = floorplan.main_part
        if is_attainable(rules, floorplan.truth, main, int(main.sum()), scenario.team):
            return floorplan
    if (room := int(main.sum())) < scenario.team:
        raise InputError(
            f"{floorplan.name}: expected room for {scenario.team} UAVs, got {room} connected free cells; "
            "use a smaller team or a larger map"
        )
    raise InputError(
        f"scenario {scenario.name!r}: {scenario.goal:.0%} of the map's cells can never be seen on {floorplan.name}; "
        "lower goal, use fewer obstacles, or denominator = 'reachable'"
    )


def draw_spawns(scenario: Scenario, floorplan: Floorplan, seed: int) -> list[Cell]:
    """Return one distinct free cell for each agent: listed, or drawn on the map's largest free part."""
    if not isinstance(scenario.spawn, str):
        return checked_spawns(scenario.spawn, floorplan)
    chosen = np.empty((scenario.team, 2), np.int64)
    ground = new_ground(floorplan.shape)
    ground.part[:] = floorplan.main_part
    start = -1 if floorplan.start is None else floorplan.start[0] * floorplan.shape[1] + floorplan.start[1]
    key = np.uint64(stream_key(seed, Stream.SPAWN))
    place_team(key, scenario.spawn == "clustered", start, floorplan.truth, ground, chosen)
    return [(int(row), int(col)) for row, col in chosen]


def checked_spawns(spawns: Sequence[Cell], floorplan: Floorplan) -> list[Cell]:
    """Return listed spawns, refusing cells that are not free or not distinct."""
    height, width = floorplan.shape
    for number, (row, col) in enumerate(spawns):
        if not (0 <= row < height and 0 <= col < width and floorplan.truth[row, col] == FREE):
            raise InputError(
                f"{floorplan.name}: spawn {number} at ({row}, {col}) is no free cell of this {height} x {width} map; "
                "list a free one"
            )
    if len({(int(row), int(col)) for row, col in spawns}) < len(spawns):
        raise InputError(f"{floorplan.name}: two UAVs cannot spawn in the same cell; list different cells")
    return list(spawns)
