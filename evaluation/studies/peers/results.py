"""The table of flights in another simulator, with ratios to its expert, and the same flights as reported rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from indoor_explorers.evaluation.drawing.formatting import fixed, interval, percent
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, words
from indoor_explorers.evaluation.harness.reported.rows import ReportedPolicy, ReportedRow, Source, write_reported
from indoor_explorers.evaluation.harness.results.ratios import Censoring
from indoor_explorers.evaluation.statistics import Block, Estimate, bootstrap_mean, paired_ratios
from indoor_explorers.evaluation.studies.peers.dare import CITATION, CODE, MOST_MOVES
from indoor_explorers.evaluation.studies.peers.flights import EXPERT, Flight

#: The scenario of the rows in reports.
SCENARIO = "dare-own-rules"
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
    return Table(columns, table, f"{len(tasks)} maps of DARE, by its own rules", "peer-dare", _notes(flights))


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


def _values(flights: Sequence[Flight], metres: Callable[[Flight], float | None]) -> tuple[np.ndarray, np.ndarray]:
    """Return (E,) metres, of flights that did not get there all that they flew, and (E,) whether they did."""
    found = [metres(flight) for flight in flights]
    values = [flight.metres if value is None else value for value, flight in zip(found, flights, strict=True)]
    return np.array(values, np.float64), np.array([value is not None for value in found], np.bool_)


def _ratio(mine: Sequence[Flight], theirs: Sequence[Flight], metres: Callable[[Flight], float | None]) -> Cell:
    """Return the mean over maps of the ratio to the expert's metres."""
    (above, ours), (below, others) = _values(mine, metres), _values(theirs, metres)
    bound = Censoring.of(ours, others).bound
    if bound is None or mine[0].policy == EXPERT or not (below > 0).all():
        return Cell(fixed(None, 0))
    maps = np.array([flight.map for flight in mine], np.str_)
    ratio: Estimate = paired_ratios([Block(above[:, None], below[:, None], maps)])[0].of_tasks
    return Cell(_bound(fixed(ratio.mean, 3), bound), ratio.mean, interval(ratio, 3))


def _bound(text: str, sign: str) -> str:
    return f"{sign} {text}" if sign else text


def _notes(flights: Sequence[Flight]) -> list[str]:
    failed = sum(flight.failure is not None for flight in flights)
    return [
        f"Measured here in the simulator of {CITATION}, commit {CODE.commit[:7]}, by its own rules: metres flown until "
        f"90 % and 99 % of the free cells are known, and until its own end, at most {MOST_MOVES} moves. / expert: mean "
        "over maps of the ratio to its expert planner's metres, with a 95 % bootstrap interval. A > stands before a "
        "lower bound: some flights did not get there, and count with all that they flew.",
        *([f"{failed} flights failed; the same command flies them again."] if failed else []),
    ]


def write_rows(flights: Sequence[Flight], folder: Path) -> None:
    """Write the flights that did not fail as reported rows, which ``report`` shows apart from flown ones.

    Their scenario and their names are of their own, so that no table takes them for flights in this world.
    """
    source = Source(citation=f"the simulator of {CITATION}", url=f"{CODE.url}/tree/{CODE.commit}", measured=True)
    names = dict.fromkeys(flight.policy for flight in flights)
    policies = [
        ReportedPolicy(
            name=f"{name} in DARE",
            source=source,
            rows=tuple(_row(flight) for flight in flights if flight.policy == name and flight.failure is None),
        )
        for name in names
    ]
    write_reported([policy for policy in policies if policy.rows], folder)


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
