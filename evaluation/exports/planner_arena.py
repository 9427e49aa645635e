"""The results as a database that Planner Arena opens, OMPL's viewer of benchmarks (plannerarena.org).

Tables and column types follow OMPL's benchmark databases (Moll, Sucan & Kavraki 2015,
"Benchmarking motion planning algorithms", IEEE Robotics & Automation Magazine 22(3), doi:10.1109/MRA.2015.2448276;
https://ompl.kavrakilab.org/benchmark.html, "The benchmark database schema"). A scenario is an experiment, a policy
a planner, an episode a run. Planner Arena labels time "s"; here every time is in steps. No run is left out or has
missing times, since plots that ignore missing values would favour policies that often fail: T_q never reached is the
budget, beside a column that says whether it was reached, and a curve continues at its last value up to the budget.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.coverage_axes import coverage_at, sampled_steps
from indoor_explorers.evaluation.analysis.facts import denominator, setting_rows
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from indoor_explorers.evaluation.harness.results.results import Results

SCHEMA = """
CREATE TABLE experiments (
    id INTEGER PRIMARY KEY AUTOINCREMENT, name VARCHAR(512), totaltime REAL, timelimit REAL, memorylimit REAL,
    runcount INTEGER, version VARCHAR(128), hostname VARCHAR(1024), cpuinfo TEXT, date DATETIME, seed VARCHAR(24),
    setup TEXT
);
CREATE TABLE plannerConfigs (id INTEGER PRIMARY KEY AUTOINCREMENT, name VARCHAR(512) NOT NULL, settings TEXT);
CREATE TABLE enums (name VARCHAR(512), value INTEGER, description TEXT, PRIMARY KEY (name, value));
CREATE TABLE runs (
    id INTEGER PRIMARY KEY AUTOINCREMENT, experimentid INTEGER, plannerid INTEGER, {columns},
    FOREIGN KEY (experimentid) REFERENCES experiments (id) ON DELETE CASCADE,
    FOREIGN KEY (plannerid) REFERENCES plannerConfigs (id) ON DELETE CASCADE
);
CREATE TABLE progress (
    runid INTEGER, time REAL, coverage REAL, coverage_worst REAL, coverage_mean REAL, PRIMARY KEY (runid, time),
    FOREIGN KEY (runid) REFERENCES runs (id) ON DELETE CASCADE
);
"""
#: Whose coverage ``progress`` has.
OF_TEAMS = ("team", "worst", "mean")
#: The texts of ``status``, by the outcome of the episode.
STATUSES = {
    Outcome.COMPLETE: "Goal coverage reached",
    Outcome.BUDGET: "Budget ran out",
    Outcome.ENDED: "Every UAV crashed or was stuck",
    Outcome.FAILED: "Policy failed",
}
#: Columns of ``runs`` that are not metrics.
FACTS = {
    "time": "REAL",
    "solved": "BOOLEAN",
    "status": "ENUM",
    "seed": "INTEGER",
    "map": "INTEGER",
    "budget": "INTEGER",
}
#: Approximate number of points of a run in ``progress``.
POINTS = 100


def write_planner_arena(results: Results, path: Path) -> None:
    """Write ``planner-arena.db``; equal results give equal bytes."""
    metrics = _metric_columns(results)
    columns = FACTS | {name: kind for name, kind in metrics.values()} | {f"{q}_reached": "BOOLEAN" for q in LEVELS}
    with written_whole(path) as partial, _new_database(partial) as database, database:
        database.executescript(SCHEMA.format(columns=", ".join(f"{name} {kind}" for name, kind in columns.items())))
        _insert(database, "enums", (("status", k, text) for k, text in enumerate(STATUSES.values())))
        _insert(database, "plannerConfigs", _planners(results))
        runs = 0
        for number, scenario in enumerate(results.scenarios, 1):
            comparison = Comparison(results, scenario)
            _insert(database, "experiments", [(number, *_experiment(results, comparison))])
            _insert(database, "progress", _progress(comparison, runs))
            rows = list(_runs(comparison, metrics))
            _insert(database, "runs", ((runs + k, number, *row) for k, row in enumerate(rows, 1)))
            runs += len(rows)


def _new_database(path: Path) -> closing[sqlite3.Connection]:
    path.unlink(missing_ok=True)  # left by an interrupted command
    return closing(sqlite3.connect(path))


def _insert(database: sqlite3.Connection, table: str, rows: Any) -> None:
    for row in rows:
        database.execute(f"INSERT INTO {table} VALUES ({', '.join('?' * len(row))})", row)


def _metric_columns(results: Results) -> dict[str, tuple[str, str]]:
    """Return column name and type of each metric that was measured; names have only letters, digits and ``_``."""
    held = {name for record in results.records for name, value in record.metrics.items() if value is not None}
    held |= {*LEVELS, *(["t99_to_reference"] if results.references else [])}
    measured = [name for name in MEASURES if name in held] + sorted(held - set(MEASURES))
    columns: dict[str, tuple[str, str]] = {}
    taken = {*FACTS, "id", "experimentid", "plannerid", "experiment", "planner", "version"}
    for metric in measured:
        stem = re.sub(r"[\W_]+", "_", metric, flags=re.ASCII).strip("_").lower() or "tally"
        name = next(each for each in (stem, *(f"{stem}_{k}" for k in range(2, 1000))) if each not in taken)
        taken.add(name)
        columns[metric] = (name, "INTEGER" if metric in LEVELS else "REAL")
    return columns


def _planners(results: Results) -> Iterator[tuple[int, str, str]]:
    for number, (name, about) in enumerate(results.policies.items(), 1):
        facts = {key: value for key, value in about.items() if key != "parameters"} | about.get("parameters", {})
        yield number, name, "".join(f"{key} = {value};\n" for key, value in facts.items())


def _experiment(results: Results, comparison: Comparison) -> tuple[Any, ...]:
    records = comparison.records
    run: Mapping[str, Any] = results.runs[-1] if results.runs else {}
    return (
        comparison.scenario,
        sum(record.metrics.get("latency_total_s") or 0.0 for record in records),
        float(max((record.budget for record in records), default=0)),
        0.0,
        max((len(group) for group in comparison.groups.values()), default=0),
        f"indoor-explorers {run.get('indoor-explorers version', '0')}",
        str(run.get("system", "unknown")),
        str(run.get("processor", "unknown")),
        str(run.get("started", "not recorded")),
        str(min((record.task.seed for record in records), default=0)),
        _setup(comparison),
    )


def _setup(comparison: Comparison) -> str:
    """Explain the numbers of this experiment, and list all settings of its scenario."""
    settings = comparison.results.scenarios[comparison.scenario]
    return (
        f"Times are in steps. Coverage is the {denominator(settings)}. A coverage never reached counts as the budget.\n"
        "totaltime: seconds of all decisions. timelimit: steps. There is no memory limit.\n"
        + "".join(f"{key} = {value}\n" for key, value, _ in setting_rows(settings))
    )


def _runs(comparison: Comparison, metrics: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    """Yield the columns of each run from ``plannerid`` on."""
    statuses, planners = list(STATUSES), list(comparison.results.policies)
    for policy, records in comparison.groups.items():
        columns = [comparison.results.values(comparison.scenario, policy, metric).tolist() for metric in metrics]
        for record, *values in zip(records, *columns, strict=True):
            facts = (float(record.steps), record.outcome is Outcome.COMPLETE, statuses.index(record.outcome))
            task = (record.task.seed, record.task.map_index, record.budget)
            reached = (record.metrics.get(level) is not None for level in LEVELS)
            yield planners.index(policy) + 1, *facts, *task, *(None if v != v else v for v in values), *reached


def _progress(comparison: Comparison, before: int) -> Iterator[tuple[Any, ...]]:
    """Yield the coverage of each run by step; the runs are numbered from ``before`` + 1."""
    if not comparison.groups:
        return
    steps, run = sampled_steps(comparison, POINTS), before
    for records in comparison.groups.values():
        for record in records:
            run += 1
            kept = steps[steps <= record.budget]
            curves = [coverage_at([record], kept, who)[0].tolist() for who in OF_TEAMS]
            yield from zip((run for _ in kept), kept.tolist(), *curves, strict=True)
