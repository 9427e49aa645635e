"""The table of flights in another simulator, with ratios to its expert, and the same flights as reported rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.formatting import fixed, interval, percent
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, words
from indoor_explorers.evaluation.harness.reported.rows import ReportedPolicy, ReportedRow, Source, write_reported
from indoor_explorers.evaluation.harness.results.ratios import Censoring
from indoor_explorers.evaluation.statistics import Block, Estimate, bootstrap_mean, paired_ratios
from indoor_explorers.evaluation.studies.peers.dare import CITATION, CODE, MOST_MOVES
from indoor_explorers.evaluation.studies.peers.flights import EXPERT, Flight

#: The scenario of the rows in reports.
SCENARIO = "dare-own-rules"
#: Name of a policy in the reported rows, with scans at nodes and with scans on the way.
NAMES = {False: "{} in DARE", True: "{} in DARE, scanning on the way"}
#: (E,) values, and whether they are no bounds, (E,) bool.
Values = tuple[NDArray[np.float64], NDArray[np.bool_]]
#: The columns of metres, and whether a flight has got there.
METRES: dict[str, Callable[[Flight], float | None]] = {
    "to 90 %": lambda flight: flight.metres_90,
    "to 99 %": lambda flight: flight.metres_99,
    "to its end": lambda flight: flight.metres if flight.done else None,
}


def flight_table(flights: Sequence[Flight], policies: Sequence[str]) -> Table:
    """Return the mean metres of policies over the tasks that all have flown, and ratios to the expert's."""
    flown = {name: {f.key[1:]: f for f in flights if f.policy == name and f.failure is None} for name in policies}
    tasks = sorted(set.intersection(*(set(each) for each in flown.values())))
    rows = {name: [each[task] for task in tasks] for name, each in flown.items()}
    columns = [words("policy", 12), Column("chosen by"), Column("done"), Column("moves")]
    for title in METRES:
        columns += [Column(title, "m"), *([Column("/ expert")] if EXPERT in policies else [])]
    table = [Row(name, _cells(mine, rows.get(EXPERT))) for name, mine in rows.items()] if tasks else []
    title = f"{len(tasks)} maps of DARE, by {_rules(flights)}"
    return Table(columns, table, title, "peer-dare", _notes(flights))


def _cells(mine: Sequence[Flight], theirs: Sequence[Flight] | None) -> list[Cell]:
    done = sum(flight.done for flight in mine)
    cells = [Cell(mine[0].chosen_by), Cell(percent(done / len(mine))), Cell(f"{np.mean([f.moves for f in mine]):.1f}")]
    for metres in METRES.values():
        values, reached = _values(mine, metres)
        estimate = bootstrap_mean(values)
        cells.append(Cell(_bound(fixed(estimate.mean, 0), "" if reached.all() else ">"), estimate.mean))
        if theirs is not None:
            cells.append(_ratio(mine, theirs, metres))
    return cells


def _values(flights: Sequence[Flight], metres: Callable[[Flight], float | None]) -> Values:
    """Return (E,) metres, of flights that did not get there all that they flew, and (E,) whether they did."""
    found = [metres(flight) for flight in flights]
    values = [flight.metres if value is None else value for value, flight in zip(found, flights, strict=True)]
    return np.array(values, np.float64), np.array([value is not None for value in found], np.bool_)


def _ratio(mine: Sequence[Flight], theirs: Sequence[Flight], metres: Callable[[Flight], float | None]) -> Cell:
    """Return the mean over maps of the ratio to the expert's metres."""
    if mine[0].policy == EXPERT:
        return Cell(fixed(None, 0))
    return ratio_cell(_values(mine, metres), _values(theirs, metres), [flight.map for flight in mine])


def ratio_cell(above: Values, below: Values, maps: Sequence[str]) -> Cell:
    """Return the mean over maps of the ratios of (E,) values to others of the same maps, as a bound where it is one."""
    (mine, ours), (theirs, others) = above, below
    bound = Censoring.of(ours, others).bound
    if bound is None or not len(mine) or not (theirs > 0).all():
        return Cell(fixed(None, 0))
    blocks = [Block(mine[:, None], theirs[:, None], np.array(maps, np.str_))]
    ratio: Estimate = paired_ratios(blocks)[0].of_tasks
    return Cell(_bound(fixed(ratio.mean, 3), bound), ratio.mean, interval(ratio, 3))


def _bound(text: str, sign: str) -> str:
    return f"{sign} {text}" if sign else text


def _rules(flights: Sequence[Flight]) -> str:
    on_the_way = any(each.scans_on_the_way for each in flights)
    return "its own rules but for scans on the way" if on_the_way else "its own rules"


def _notes(flights: Sequence[Flight]) -> list[str]:
    failed = sum(flight.failure is not None for flight in flights)
    return [
        f"Measured here in the simulator of {CITATION}, commit {CODE.commit[:7]}, by {_rules(flights)}: metres flown "
        f"until 90 % and 99 % of the free cells are known, and until its own end, at most {MOST_MOVES} moves. "
        "/ expert: mean over maps of the ratio to its expert planner's metres, with a 95 % bootstrap interval. A > "
        "stands before a lower bound: some flights did not get there, and count with all that they flew.",
        *([f"{failed} flights failed; the same command flies them again."] if failed else []),
    ]


def write_rows(flights: Sequence[Flight], folder: Path) -> None:
    """Write the flights that did not fail as reported rows, which ``report`` shows apart from flown ones.

    Their scenario and their names are of their own, so that no table takes them for flights in this world.
    """
    source = Source(citation=f"the simulator of {CITATION}", url=f"{CODE.url}/tree/{CODE.commit}", measured=True)
    rows: dict[str, list[ReportedRow]] = {}
    for flight in flights:
        if flight.failure is None:
            rows.setdefault(NAMES[flight.scans_on_the_way].format(flight.policy), []).append(_row(flight))
    write_reported([ReportedPolicy(name=name, source=source, rows=tuple(each)) for name, each in rows.items()], folder)


def _row(flight: Flight) -> ReportedRow:
    return ReportedRow(
        scenario=SCENARIO,
        map=flight.map,
        seed=flight.seed,
        team=1,
        budget=MOST_MOVES,
        metrics={"path_max_m": flight.metres},
        success=float(flight.done),
    )
