"""The radio model ``path-loss`` beside ns-3's propagation inside of buildings, on pairs of cells of generated floors.

``radio_ns3.py`` asks ns-3 and writes ``radio_ns3.csv``; what the page on it shows is computed from that file, without
ns-3. Losses are in decibels relative to one metre.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from indoor_explorers.env import FREE, scenario
from indoor_explorers.env.grid.lines import walls_between
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.drawing.formatting import percent

MEASURED = Path(__file__).parent / "radio_ns3.csv"
#: Seeds of the floors of the scenario ``floors``, pairs of cells on each, and their smallest and largest distance.
SEEDS, PAIRS, METRES = range(10), 120, (1.0, 40.0)
#: How far the distance of a pair may be from the one that was drawn, in metres.
NEAR = 0.25
#: The exponent and the decibels of a wall: the defaults of ``path-loss``, and of ns-3 in an office.
DEFAULTS, OFFICE = (3.0, 6.0), (3.0, 5.0)
#: The same of other standards: the free space and light or heavy walls of COST 231, and P.1238 without further walls.
STANDARDS = {
    "`path-loss`, defaults": DEFAULTS,
    "`path-loss`, 5 dB a wall": OFFICE,
    "COST 231, light walls": (2.0, 3.4),
    "COST 231, heavy walls": (2.0, 6.9),
    "P.1238, office": (3.0, 0.0),
}
#: Ranges in the open that contacts are compared at, in metres.
RANGES = (10.0, 15.0, 20.0, 30.0, 40.0)


class Pair(NamedTuple):
    """Two cells of a floor, and the walls on the straight line between them."""

    row: int
    col: int
    to_row: int
    to_col: int
    walls: int


class RoomGrid(NamedTuple):
    """A floor as ns-3 has it: a box in metres, divided into equal rooms."""

    left: float
    right: float
    top: float
    bottom: float
    across: int
    """Rooms from left to right."""
    down: int


def floors() -> Iterator[tuple[int, Floorplan]]:
    """Yield the seeds and floors of the comparison."""
    for seed in SEEDS:
        yield seed, scenario("floors").map.floorplan(0, seed)


def pairs_of(seed: int, plan: Floorplan) -> Iterator[Pair]:
    """Yield random pairs of cells: the first uniform on the floor, the distance uniform in :data:`METRES`."""
    rng = np.random.default_rng(seed)
    cells = np.argwhere(plan.main_part)
    found = 0
    while found < PAIRS:
        cell, wanted = cells[rng.integers(len(cells))], rng.uniform(*METRES)
        metres = np.hypot(*(cells - cell).T) * (plan.resolution or 1.0)
        others = cells[(np.abs(metres - wanted) <= NEAR) & (metres >= METRES[0])]
        if len(others):
            (row, col), (to_row, to_col) = cell.tolist(), others[rng.integers(len(others))].tolist()
            yield Pair(row, col, to_row, to_col, walls_between(plan.truth, row, col, to_row, to_col))
            found += 1


def room_grid(plan: Floorplan) -> RoomGrid:
    """Return the box around a floor, with as many rooms as its rows and columns of cells cross walls on average."""
    metres = plan.resolution or 1.0
    rows, cols = (np.flatnonzero(plan.main_part.any(axis=axis)) for axis in (1, 0))
    box = plan.truth[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1] == FREE
    left, top = int(cols[0]) * metres, int(rows[0]) * metres
    across, down = 1 + round(_walls_per_cell(box) * box.shape[1]), 1 + round(_walls_per_cell(box.T) * box.shape[0])
    return RoomGrid(left, left + box.shape[1] * metres, top, top + box.shape[0] * metres, across, down)


def _walls_per_cell(free: NDArray[np.bool_]) -> float:
    """Return how many walls the rows of a mask cross for each cell, between their first and last free cells."""
    walls = cells = 0
    for row in free:
        (inside,) = row.nonzero()
        if len(inside):
            walls += int((np.diff(inside) > 1).sum())
            cells += int(inside[-1] - inside[0]) + 1
    return walls / cells


def measured() -> pd.DataFrame:
    """Return the pairs with the losses that ns-3 gave, and their distances in ``metres``."""
    table = pd.read_csv(MEASURED)
    cells = np.hypot(table["to_row"] - table["row"], table["to_col"] - table["col"])
    table["metres"] = cells * (scenario("floors").map.floorplan(0, 0).resolution or 1.0)
    return table


def loss(pairs: pd.DataFrame, exponent: float, wall_loss: float) -> NDArray[np.float64]:
    """Return the loss by ``path-loss``."""
    return np.asarray(open_loss(pairs["metres"].to_numpy(), exponent) + wall_loss * pairs["walls"].to_numpy())


def open_loss(metres: NDArray[np.float64] | float, exponent: float) -> NDArray[np.float64]:
    """Return the loss of a distance without walls."""
    return np.asarray(10.0 * exponent * np.log10(metres))


def contacts(pairs: pd.DataFrame, metres: float) -> dict[str, NDArray[np.bool_]]:
    """Return which pairs are in contact, by model, where the range in the open is that many metres."""
    found = {name: loss(pairs, *rule) <= open_loss(metres, rule[0]) + 1e-9 for name, rule in STANDARDS.items()}
    return found | {
        "ns-3": pairs["ns3_db"].to_numpy() <= open_loss(metres, OFFICE[0]) + 1e-6,
        "ns-3, shadowed": pairs["ns3_shadowed_db"].to_numpy() <= open_loss(metres, OFFICE[0]) + 1e-6,
    }


def range_table(model: str = "`path-loss`, defaults") -> list[str]:
    """Return the rows of the table of contacts by range, in Markdown: by a model, by ns-3, and by one of them alone."""
    pairs, rows = measured(), []
    for metres in RANGES:
        within = pairs[pairs["metres"] <= metres]
        found = contacts(within, metres)
        one, ns3, shadowed = found[model], found["ns-3"], found["ns-3, shadowed"]
        shares = (one, ns3, one & ~ns3, ns3 & ~one, shadowed != ns3)
        rows.append(f"| {metres:.0f} m | {len(within)} | {_cells(shares)} |")
    return rows


def model_table(metres: float) -> list[str]:
    """Return the rows of the table of models at one range: pairs in contact, and those by that or ns-3 alone."""
    pairs = measured()
    pairs = pairs[pairs["metres"] <= metres]
    found = contacts(pairs, metres)
    rows = []
    for name, (exponent, wall_loss) in STANDARDS.items():
        shares = (found[name], found[name] & ~found["ns-3"], found["ns-3"] & ~found[name])
        rows.append(f"| {name} | {exponent} | {wall_loss} | {_cells(shares)} |")
    return rows


def _cells(shares: tuple[NDArray[np.bool_], ...]) -> str:
    return " | ".join(percent(share.mean()) for share in shares)
