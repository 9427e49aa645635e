"""Tables of steps as ratios to a baseline's, kinds and sources of maps by policies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from indoor_explorers.evaluation.analysis.tables.ratio_table import ratio_cell
from indoor_explorers.evaluation.drawing.formatting import counted
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, words
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES
from indoor_explorers.evaluation.harness.results.origin_ratios import OriginRatios
from indoor_explorers.evaluation.harness.results.ratios import POOLED, RatioRow

#: The key of the column of the number of maps.
MAPS = "maps"


def origin_tables(parts: Sequence[OriginRatios]) -> list[Table]:
    """Return a table for each baseline and time, highest threshold first; empty if maps are of one kind and source.

    A row is a kind or a source, with its number of maps; a figure is over all scenarios with such maps, each with the
    same weight, and shaded as in :func:`~.ratio_table.ratio_tables`.
    """
    pairs = {(to, metric): None for part in parts for to in part.ratios.to for metric in part.ratios.metrics[::-1]}
    tables = [_table(parts, *pair) for pair in pairs]
    return [table for table in tables if len(table.columns) > 2]


def _table(parts: Sequence[OriginRatios], to: str, metric: str) -> Table:
    found = {part.title: _over_scenarios(part, to, metric) for part in parts}
    policies = [name for name in parts[0].ratios.results.policies if any(name in rows for rows in found.values())]
    return Table(
        [words("maps of", 12), Column(MAPS), *map(Column, policies)],
        [Row(part.title, [_maps(part), *(found[part.title].get(name, Cell()) for name in policies)]) for part in parts],
        f"{MEASURES[metric].title} as a ratio to {to}, by kind and source of the maps",
        f"{metric}_to_{to}_by_origin",
        [f"Steps divided by those of {to} on the maps of a row, scenarios of equal weight; below 1 is faster."],
    )


def _maps(part: OriginRatios) -> Cell:
    several = f"in {counted(part.units, part.unit)}" if part.units < part.maps else ""
    return Cell(str(part.maps), detail=several)


def _over_scenarios(part: OriginRatios, to: str, metric: str) -> dict[str, Cell]:
    """Return a cell for each policy: over all scenarios, or of the only one."""
    rows = [row for row in part.ratios.rows if (row.to, row.metric) == (to, metric)]
    scenarios = len({row.scenario for row in rows} - {POOLED})
    return {row.policy: ratio_cell(row, scenarios) for row in _last(rows, scenarios)}


def _last(rows: Sequence[RatioRow], scenarios: int) -> Iterator[RatioRow]:
    return (row for row in rows if scenarios == 1 or row.scenario == POOLED)
