"""The rows behind the page on where learning pays, taken from the tables of the suite ``atlas``.

``python -m indoor_explorers.evaluation.site.studies.atlas DIR`` takes them from the folder ``tables`` of a report
that was written with ``--ratio-to`` every planner; the site and the tests read them alone.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from indoor_explorers.evaluation.analysis.best_planner import PlannerRow, read_best_planner
from indoor_explorers.evaluation.analysis.tables.planner_table import best_steps, planner_cell
from indoor_explorers.evaluation.harness.results.ratios import POOLED
from indoor_explorers.evaluation.statistics import Finding

#: Every policy against the best planner of each task, and what each learned part is worth there.
PLANNERS, PARTS = (Path(__file__).parent / f"{name}.csv" for name in ("atlas_planners", "atlas_parts"))
LEARNER = "dddqn"


class Part(NamedTuple):
    """A learned part: the same policy with it and without it."""

    title: str
    policy: str
    without: str


LEARNED = (
    Part("learned estimates", "frontier-predictive", "frontier-latency"),
    Part("learned choice", LEARNER, "dddqn(network=false)"),
)


def take(tables: Path) -> None:
    """Keep the rows of a report's tables that the page needs."""
    PLANNERS.write_bytes((tables / "best_planner.csv").read_bytes())
    header, *lines = (tables / "ratios.csv").read_text("utf-8").splitlines(keepends=True)
    rows = pd.read_csv(tables / "ratios.csv")
    pairs = {(part.policy, part.without) for part in LEARNED}
    found = zip(rows["policy"], rows["to"], rows["scenario"] == POOLED, strict=True)
    needed = [(policy, to) in pairs or (policy == LEARNER and pooled) for policy, to, pooled in found]
    kept = [line for line, keep in zip(lines, needed, strict=True) if keep]
    PARTS.write_text(header + "".join(kept), "utf-8")


def planner_rows() -> list[PlannerRow]:
    """Return every policy against the best planner, by task."""
    return read_best_planner(PLANNERS)


def parts() -> pd.DataFrame:
    """Return the ratios of the policies with a learned part to those without it, and the learner over all tasks."""
    return pd.read_csv(PARTS)


def of_part(part: Part) -> pd.DataFrame:
    """Return the ratios of a learned part, one for each time and task, and over all tasks."""
    table = parts()
    return table[(table["policy"] == part.policy) & (table["to"] == part.without)]


def short(scenario: str) -> str:
    """Return the name of a task without that of the suite."""
    return scenario.removeprefix("atlas-")


def finding_table(rows: Sequence[PlannerRow]) -> Iterator[str]:
    """Yield the rows of the table of what is shown of the learner, in Markdown."""
    found: dict[str, list[str]] = {each: [] for each in Finding}
    for row in rows:
        each = row.policies[LEARNER]
        needed = f" ({each.needed:,.0f})" if each.finding is Finding.OPEN else ""
        found[each.finding or Finding.OPEN].append(f"`{short(row.title)}`{needed}")
    for name, tasks in found.items():
        if tasks:
            yield f"| {name} | {len(tasks)} | {', '.join(tasks)} |"


def specialist_table(rows: Sequence[PlannerRow]) -> Iterator[str]:
    """Yield a row of Markdown for each task in which the learner flew inside a specialist too, or as one."""
    for row in rows:
        names = [name for name, each in row.policies.items() if each.learner and name != LEARNER]
        for name in names:
            alone, inside = (planner_cell(row, each).line for each in (LEARNER, name))
            best = f"`{row.planner}`, {best_steps(row, 0)}"
            yield f"| `{short(row.title)}`, {row.best.row.tasks} | {best} | {alone} | `{name}`: {inside} |"


def ratio_of(scenario: str, metric: str, policy: str, to: str) -> str:
    """Return a ratio of :func:`parts` with its interval, or how often both never reached 99 %."""
    table = parts()
    here = (table["scenario"] == scenario) & (table["metric"] == metric)
    row = table[here & (table["policy"] == policy) & (table["to"] == to)].iloc[0]
    if row["mean_of_ratios"] == row["mean_of_ratios"]:
        return f"{row['mean_of_ratios']:.3f} [{row['low']:.3f}, {row['high']:.3f}]"
    ours, theirs = (int(row[name] + row["never_both"]) for name in ("never_policy", "never_baseline"))
    return f"{ours} and {theirs} of {int(row['tasks'])}"


def pooled_table() -> Iterator[str]:
    """Yield the learner over all tasks against each other policy that knows no map, in Markdown."""
    for to in dict.fromkeys(parts()["to"]):
        table = parts()
        of = table[(table["scenario"] == POOLED) & (table["policy"] == LEARNER) & (table["to"] == to)]
        if len(of):
            cells = (ratio_of(POOLED, metric, LEARNER, to) for metric in ("t90", "t99"))
            counts = " / ".join(str(count) for count in of.sort_values("metric")["scenarios"])
            yield f"| `{to}` | {' | '.join(cells)} | {counts} |"


if __name__ == "__main__":
    take(Path(sys.argv[1]))
