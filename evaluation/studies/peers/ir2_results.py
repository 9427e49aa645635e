"""The table of flights of teams in the simulator of IR2, beside imported rows, and the flights as reported rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from indoor_explorers.evaluation.drawing.formatting import counted, fixed, interval, percent
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, words
from indoor_explorers.evaluation.harness.reported.rows import ReportedPolicy, ReportedRow, Source, write_reported
from indoor_explorers.evaluation.statistics import bootstrap_mean
from indoor_explorers.evaluation.studies.peers.ir2 import CITATION, CODE, SETS
from indoor_explorers.evaluation.studies.peers.ir2_flights import TeamFlight
from indoor_explorers.evaluation.studies.peers.results import Values, ratio_cell

#: The metrics of rows, with the columns of the table: steps until the last robot knows 99 %, and the longest path.
METRICS = {"t99_worst": ("steps", ""), "path_max_m": ("longest path", "px")}
#: Name of a policy in the reported rows of flights with maps that robots out of contact share, and with mended ones.
NAMES = {False: "{} in IR2", True: "{} in IR2, mended"}


def scenario_of(part: str) -> str:
    """Return the scenario that rows of a test set have."""
    return f"ir2-{part}-own-rules"


def flight_table(
    flights: Sequence[TeamFlight], policies: Sequence[str], part: str, others: Sequence[ReportedPolicy] = ()
) -> Table:
    """Return the means of policies on the maps that all have flown, and ratios to reported policies by map."""
    good = [each for each in flights if each.failure is None]
    flown = {name: {each.map: _row(each) for each in good if each.policy == name} for name in policies}
    maps = sorted(set.intersection(*(set(each) for each in flown.values())))
    columns, rows = [words("policy", 12), Column("done")], []
    theirs = {
        each.name: {row.map: row for row in each.on(scenario_of(part)) if row.map and row.n is None} for each in others
    }
    for title, unit in METRICS.values():
        columns += [Column(title, unit), *(Column(f"/ {name}") for name in theirs)]
    for name, mine in flown.items():
        if maps:
            rows.append(Row(name, _cells({each: mine[each] for each in maps}, list(theirs.values()))))
    for name, held in theirs.items():
        if shared := {each: held[each] for each in maps if each in held}:
            rows.append(Row(name, _cells(shared, [{} for _ in theirs])))
    return Table(
        columns,
        rows,
        f"{counted(len(maps), 'map')} of IR2's {part}, by its own rules",
        "peer-ir2",
        _notes(flights, part),
    )


def _cells(mine: Mapping[str, ReportedRow], others: Sequence[Mapping[str, ReportedRow]]) -> list[Cell]:
    cells = [Cell(percent(sum(row.success or 0.0 for row in mine.values()) / len(mine)))]
    for metric in METRICS:
        estimate = bootstrap_mean(_values(list(mine.values()), metric)[0])
        cells.append(Cell(fixed(estimate.mean, 1), estimate.mean, interval(estimate, 1)))
        for theirs in others:
            maps = [each for each in mine if each in theirs]
            ours, other = (_values([rows[each] for each in maps], metric) for rows in (mine, theirs))
            cells.append(ratio_cell(ours, other, maps))
    return cells


def _values(rows: Sequence[ReportedRow], metric: str) -> Values:
    """Return values, where the end was not reached those at the last step."""
    values = [row.budget if (value := row.metrics.get(metric)) is None else value for row in rows]
    return np.array(values, np.float64), np.array([row.success == 1.0 for row in rows], np.bool_)


def _notes(flights: Sequence[TeamFlight], part: str) -> list[str]:
    settings, failed = SETS[part], sum(each.failure is not None for each in flights)
    maps = "each robot in a map of its own" if any(each.mended for each in flights) else "as it is"
    return [
        f"Measured here in the simulator of {CITATION}, commit {CODE.commit[:7]}, {maps}: steps until each of the "
        f"{settings.team} robots knows 99 % of the free pixels, {settings.most_steps} at most, and pixels flown by the "
        "one that flies most. / : mean over maps of the ratio, with a 95 % bootstrap interval. Flights that are not "
        "done count with what they flew: > and < stand before bounds, \N{ALMOST EQUAL TO} where few are not done.",
        *([f"{counted(failed, 'flight')} failed; the same command flies what failed again."] if failed else []),
    ]


def write_rows(flights: Sequence[TeamFlight], folder: Path) -> None:
    """Write the flights that did not fail as reported rows, which ``report`` shows apart from flown ones."""
    source = Source(citation=f"the simulator of {CITATION}", url=f"{CODE.url}/tree/{CODE.commit}", measured=True)
    good = [each for each in flights if each.failure is None]
    names = dict.fromkeys(NAMES[each.mended].format(each.policy) for each in good)
    rows = {
        name: tuple(_row(each) for each in good if NAMES[each.mended].format(each.policy) == name) for name in names
    }
    write_reported([ReportedPolicy(name=name, source=source, level=0.99, rows=rows[name]) for name in names], folder)


def _row(flight: TeamFlight) -> ReportedRow:
    settings = SETS[flight.part]
    return ReportedRow(
        **{"scenario": scenario_of(flight.part), "map": flight.map, "seed": flight.seed, "team": settings.team},
        budget=settings.most_steps,
        metrics={"t99_worst": flight.steps if flight.done else None, "path_max_m": flight.pixels},
        success=float(flight.done),
    )
