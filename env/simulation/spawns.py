"""The map and the spawns that an episode's seed determines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.grid.levels import Voxel
from indoor_explorers.env.grid.randomness import Stream, stream_key
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.reset import MAX_ATTEMPTS, flood_scratch, is_attainable, place_team
from indoor_explorers.env.simulation.state import rules_of


def draw_floorplan(scenario: Scenario, seed: int, index: int = 0) -> Floorplan:
    """Return the map of an episode seed, drawn again if the goal is not attainable on it."""
    rules = rules_of(scenario)
    for attempt in range(MAX_ATTEMPTS if scenario.map.generated else 1):
        floorplan = scenario.map.floorplan(index, seed, attempt)
        main = floorplan.main_part
        if is_attainable(rules.count_all_cells, rules.goal, floorplan.truth, main, int(main.sum()), scenario.team):
            return floorplan
    _check_space(floorplan, scenario.team)
    raise InputError(
        f"scenario {scenario.name!r}: {scenario.goal:.0%} of the map's cells can never be seen on {floorplan.name}; "
        "lower goal, use fewer obstacles, or denominator = 'reachable'"
    )


def draw_spawns(scenario: Scenario, floorplan: Floorplan, seed: int) -> list[Cell]:
    """Return one distinct free cell for each agent: listed, or drawn on the map's largest free part."""
    if not isinstance(scenario.spawn, str):
        return checked_spawns(scenario.spawn, floorplan, scenario.team)
    _check_space(floorplan, scenario.team)
    chosen = np.empty((scenario.team, 2), np.int64)
    scratch = flood_scratch(floorplan.shape)
    scratch.part[:] = floorplan.main_part
    start = -1 if floorplan.start is None else floorplan.start[0] * floorplan.shape[1] + floorplan.start[1]
    key = np.uint64(stream_key(seed, Stream.SPAWN))
    place_team(key, scenario.spawn == "clustered", start, floorplan.truth, scratch, chosen, floorplan.levels.rise)
    return [(int(row), int(col)) for row, col in chosen]


def _check_space(floorplan: Floorplan, team: int) -> None:
    """Refuse a map whose main part has fewer cells than the team has UAVs."""
    if (size := int(floorplan.main_part.sum())) < team:
        raise InputError(
            f"{floorplan.name}: expected room for {team} UAVs, got {size} connected free cells; "
            "use a smaller team or a larger map"
        )


def checked_spawns(spawns: Sequence[Cell | Voxel], floorplan: Floorplan, team: int) -> list[Cell]:
    """Return listed spawns; refuse a wrong number of them and cells that are not free or not distinct."""
    if len(spawns) != team:
        raise InputError(f"expected a spawn for each of {team} UAVs, got {len(spawns)}")
    height, width = floorplan.shape
    cells = [floorplan.levels.cell(cell) if len(cell) == 3 else cell for cell in spawns]
    for number, (row, col) in enumerate(cells):
        if not (0 <= row < height and 0 <= col < width and floorplan.truth[row, col] == FREE):
            raise InputError(
                f"{floorplan.name}: spawn {number} at ({row}, {col}) is no free cell of this {height} x {width} map; "
                "list a free one"
            )
    if len({(int(row), int(col)) for row, col in cells}) < len(cells):
        raise InputError(f"{floorplan.name}: two UAVs cannot spawn in the same cell; list different cells")
    return cells
