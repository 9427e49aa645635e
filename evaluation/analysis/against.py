"""What changed significantly between old and new results, paired task by task."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.text import Text

from indoor_explorers.evaluation.drawing.formatting import counted, decimals_for, fixed, with_interval
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, terminal_table, words
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES, OF_THE_MACHINE, Measure
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.results.combine import scenario_difference
from indoor_explorers.evaluation.harness.results.policy_version import differing_fields, version_difference
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import (
    CONFIDENCE,
    Estimate,
    holm,
    paired_difference,
    sign_flip_test,
    smallest_detectable_difference,
)

SUCCESS = Measure("goal reached", "share of episodes", "episodes that reached the scenario's goal coverage", False)
#: The metrics that are compared; the scenario's own times replace the times here.
HEADLINE = ("auc", "t90", "t99", "success", "path_length", "collisions", "overlap", "messages_bytes", "latency_p50_us")


def _measure(metric: str) -> Measure:
    return SUCCESS if metric == "success" else MEASURES[metric]


@dataclass(frozen=True, eq=False)
class _Pairs:
    """The values of one metric on the tasks of both results."""

    scenario: str
    policy: str
    metric: str
    old: NDArray[np.float64]
    """(E,) values."""
    new: NDArray[np.float64]
    maps: NDArray[np.str_]
    """(E,) which map each task is on."""

    @property
    def differences(self) -> NDArray[np.float64]:
        """(E,) new minus old."""
        return self.new - self.old


@dataclass(frozen=True)
class Change:
    """One metric of one policy on one scenario, new against old."""

    scenario: str
    policy: str
    metric: str
    """One of :data:`HEADLINE`, or the time to the scenario's threshold."""
    old: float
    """Mean over the tasks of both results."""
    new: float
    difference: Estimate
    """Mean of new minus old with its interval."""
    adjusted_p: float
    """p-value of the sign-flip test, adjusted by Holm's method over all changes."""
    detectable: float
    """Smallest true difference found with 80 % power; infinite where there are too few tasks for any."""

    @property
    def shown(self) -> bool:
        """Whether the change is significant, adjusted for the number of comparisons."""
        return self.adjusted_p <= 1 - CONFIDENCE

    @property
    def better(self) -> bool:
        """Whether the new mean is the better one."""
        return (self.difference.mean < 0) == _measure(self.metric).lower_is_better

    @property
    def verdict(self) -> str:
        """The result in words."""
        if self.shown:
            return ("better" if self.better else "worse") + (
                ", or the machine" if self.metric in OF_THE_MACHINE else ""
            )
        return "too few tasks" if math.isinf(self.detectable) else "not significant"

    @property
    def title(self) -> str:
        """The metric and its unit."""
        measure = _measure(self.metric)
        return f"{measure.title} [{measure.unit}]" if measure.unit else measure.title

    @property
    def decimals(self) -> int:
        """Number of decimals: as usual for this size, and enough for two digits of the difference, at most six."""
        largest, difference = max(abs(self.old), abs(self.new)), abs(self.difference.mean)
        usual = 3 if largest <= 1 else decimals_for(largest, most=2)
        return max(usual, min(6, 1 - math.floor(math.log10(difference)))) if difference else usual

    @property
    def figures(self) -> tuple[str, str, str, str]:
        """Old, new, difference with its interval, and detectable difference, as text."""
        return (
            fixed(self.old, self.decimals),
            fixed(self.new, self.decimals),
            with_interval(self.difference, self.decimals, sign=True),
            fixed(None if math.isinf(self.detectable) else self.detectable, self.decimals),
        )


@dataclass(frozen=True)
class Identity:
    """How many episodes of a policy on a scenario are identical in both results."""

    scenario: str
    policy: str
    same: int
    tasks: int
    parameters: str
    """What differs in the policy itself; empty if nothing does."""

    @property
    def text(self) -> str:
        """Its line in the report."""
        what = f"{self.same} of {counted(self.tasks, 'episode')} identical, step for step"
        return what + (f"; the policy differs: {self.parameters}" if self.parameters else "")


@dataclass(frozen=True)
class Against:
    """The whole comparison of new results with old ones."""

    changes: list[Change]
    """Significant ones come first; metrics without any difference are left out."""
    identities: list[Identity]
    apart: list[str]
    """A line for everything that only one of the results has, or that is another task in both."""

    @property
    def shown(self) -> int:
        """How many changes are significant."""
        return sum(change.shown for change in self.changes)


def compare_with(new: Results, old: Results) -> Against:
    """Compare new results with old ones of the same names, over the tasks of both.

    The p-values of all comparisons together are adjusted by Holm's method. Metrics that are the same in every
    episode are left out.
    """
    groups = list(_common(new, old))
    pairs = [each for group in groups for each in _pairs(new, old, *group) if each.differences.any()]
    changes = _changes(pairs)
    identities = [_identity(new, old, *group) for group in groups]
    return Against(sorted(changes, key=lambda change: not change.shown), identities, list(_apart(new, old)))


def _common(new: Results, old: Results) -> Iterator[tuple[str, str]]:
    """Yield the (scenario, policy) pairs that both results have for the same task."""
    like = {name for name in new.scenarios if name in old.scenarios and not scenario_difference(old, new, name)}
    for scenario, policy in new.groups:
        if scenario in like and (scenario, policy) in old.groups and _paired(new, old, scenario, policy):
            yield scenario, policy


def _paired(new: Results, old: Results, scenario: str, policy: str) -> list[tuple[Record, Record]]:
    before = {record.task: record for record in old.groups[scenario, policy]}
    return [(record, before[record.task]) for record in new.groups[scenario, policy] if record.task in before]


def _pairs(new: Results, old: Results, scenario: str, policy: str) -> Iterator[_Pairs]:
    tasks = [record.task for record, _ in _paired(new, old, scenario, policy)]
    places = [{r.task: k for k, r in enumerate(each.groups[scenario, policy])} for each in (new, old)]
    ours, theirs = ([place[task] for task in tasks] for place in places)
    maps = new.maps(scenario, policy)[ours]
    for metric in _compared(new, scenario):
        after = _values(new, scenario, policy, metric)[ours]
        before = _values(old, scenario, policy, metric)[theirs]
        held = ~np.isnan(after) & ~np.isnan(before)
        if metric in LEVELS:  # times are compared where both finished, as between policies
            held &= new.reached(scenario, policy, metric)[ours] & old.reached(scenario, policy, metric)[theirs]
        if held.any():
            yield _Pairs(scenario, policy, metric, before[held], after[held], maps[held])


def _compared(results: Results, scenario: str) -> list[str]:
    """Return the metrics compared in a scenario: :data:`HEADLINE` with the times of its threshold."""
    times, others = results.level(scenario).times, [metric for metric in HEADLINE if metric not in LEVELS]
    return [*others[:1], *times, *others[1:]]


def _values(results: Results, scenario: str, policy: str, metric: str) -> NDArray[np.float64]:
    """Return (E,) values of a metric, or 1 where an episode reached its goal."""
    if metric != "success":
        return results.values(scenario, policy, metric)
    return np.array([r.outcome is Outcome.COMPLETE for r in results.groups[scenario, policy]], np.float64)


def _changes(pairs: list[_Pairs]) -> Iterator[Change]:
    adjusted = holm([sign_flip_test(each.differences, each.maps) for each in pairs]).tolist()
    for each, p_value in zip(pairs, adjusted, strict=True):
        level = (1 - CONFIDENCE) / len(pairs)
        yield Change(
            each.scenario,
            each.policy,
            each.metric,
            float(each.old.mean()),
            float(each.new.mean()),
            paired_difference(each.new, each.old, maps=each.maps),
            p_value,
            smallest_detectable_difference(each.differences, level=level, maps=each.maps),
        )


def _identity(new: Results, old: Results, scenario: str, policy: str) -> Identity:
    pairs = _paired(new, old, scenario, policy)
    same = sum(after.flew_like(before) for after, before in pairs)
    return Identity(scenario, policy, same, len(pairs), _policy_difference(old.policies[policy], new.policies[policy]))


def _policy_difference(old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    """Name what differs in a policy: only the class if that differs, else the parameters."""
    if old.get("class") != new.get("class"):
        return differing_fields({"class": old.get("class")}, {"class": new.get("class")})
    return version_difference(old, new)


def _apart(new: Results, old: Results) -> Iterator[str]:
    for name in [*new.scenarios, *(name for name in old.scenarios if name not in new.scenarios)]:
        if name not in old.scenarios or name not in new.scenarios:
            yield f"scenario {name!r} is in the {'new' if name in new.scenarios else 'old'} results only"
        elif difference := scenario_difference(old, new, name):
            yield f"scenario {name!r} is not the same task in both; what differs: {difference}"
        else:
            yield from _apart_within(new, old, name)


def _apart_within(new: Results, old: Results, scenario: str) -> Iterator[str]:
    for policy in [*new.policies, *(policy for policy in old.policies if policy not in new.policies)]:
        key = (scenario, policy)
        if (key in new.groups) != (key in old.groups):
            yield f"policy {policy!r} flew {scenario!r} in the {'new' if key in new.groups else 'old'} results only"
        elif key in new.groups:
            ours, theirs = ({record.task for record in each.groups[key]} for each in (new, old))
            if ours != theirs:
                common = counted(len(ours & theirs), "task")
                yield f"policy {policy!r} on {scenario!r}: {common} in both, {len(ours ^ theirs)} in one only"


#: Width in characters from which old and new means are shown beside their difference.
WIDE = 110


def against_lines(against: Against, width: int = WIDE) -> Iterator[RenderableType]:
    """Yield the parts of the terminal's output: a table, significant changes first, and what could not be compared."""
    if against.changes:
        yield terminal_table(_table(against, width >= WIDE))
    yield Text(f"{against.shown} of {counted(len(against.changes), 'comparison')} changed significantly")
    for each in against.identities:
        yield Text(f"{each.scenario}, {each.policy}: {each.text}")
    for line in against.apart:
        yield Text(line, "yellow")


def _table(against: Against, wide: bool) -> Table:
    headings = ("old", "new", "new - old", "detectable") if wide else ("new - old",)
    rows, several = list[Row](), len({change.scenario for change in against.changes}) > 1
    for scenario, changes in groupby(against.changes, lambda change: change.scenario):
        rows += [Row(scenario)] if several else []
        for change in changes:
            figures = map(Cell, (change.title, *(change.figures if wide else change.figures[2:3])))
            rows.append(Row(change.policy, [*figures, Cell(change.verdict, style=_style(change))]))
    return Table([words("policy", 14), Column("figure", left=True), *map(Column, headings), words("")], rows)


def _style(change: Change) -> str:
    if not change.shown:
        return "dim"
    return "bold green" if change.better else "bold red"
