"""The leaderboard of a part of a suite, or of other tasks: which results are complete, and the ranks of policies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.experiment.selection import DEFAULT_BASELINE
from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.analysis.ranks import Rank, ranks
from indoor_explorers.evaluation.results.combine import combined
from indoor_explorers.evaluation.results.ratios import RatioRow, Ratios
from indoor_explorers.evaluation.results.results import Results


@dataclass(frozen=True)
class Origin:
    """Where the episodes of a policy come from."""

    commits: tuple[str, ...]
    """Commits of the software, seven characters each."""
    dates: tuple[str, ...]
    """Days on which runs began."""
    machines: tuple[str, ...]
    commands: tuple[str, ...]

    @property
    def flown(self) -> str:
        """Commits and days."""
        return ", ".join([*self.commits, *self.dates])

    @classmethod
    def of(cls, results: Results) -> Origin:
        """Read the facts of the runs."""
        runs = results.runs
        return cls(
            *(
                tuple(dict.fromkeys(told))
                for told in (
                    [str(run.get("commit", "unknown"))[:7] for run in runs],
                    [str(run.get("started", "unknown"))[:10] for run in runs],
                    [f"{run.get('processor', 'unknown')}, {run.get('cores', '?')} cores" for run in runs],
                    [str(run.get("command") or "") for run in runs],
                )
            )
        )


@dataclass(frozen=True)
class BoardRow:
    """One policy on one scenario."""

    policy: str
    rank: Rank | None
    """None for policies that are not ranked, and where a scenario has a single one or too few tasks."""
    to_baseline: RatioRow | None
    """Steps to the scenario's threshold divided by the baseline's."""
    origin: Origin


@dataclass(frozen=True, eq=False)
class Board:
    """The complete results of a part of a suite, or of other tasks."""

    title: str
    """Suite, version and part; or the scenarios and seeds."""
    about: str
    """What the tasks are; empty where no suite tells."""
    results: Results
    origins: Mapping[tuple[str, str], Origin]
    """By scenario and policy."""
    left_out: tuple[str, ...]
    """A line for each policy and scenario of which episodes are missing."""

    @property
    def flown(self) -> list[str]:
        """Commits and days of all origins, each once."""
        return list(dict.fromkeys(origin.flown for origin in self.origins.values()))

    @cached_property
    def comparisons(self) -> list[Comparison]:
        """The scenarios that any policy flew completely."""
        return [Comparison(self.results, scenario) for scenario in self.results.scenarios]

    def rows(self, comparison: Comparison) -> Iterator[BoardRow]:
        """Yield the policies of a scenario by rank, then mean time; those that are not ranked come last."""
        places, ratios = ranks(comparison), self._ratios
        last = Rank(len(places) + 1, False)
        for policy in sorted(comparison.ranking, key=lambda name: places.get(name, last).place):
            key = comparison.scenario, policy
            ratio = ratios.get((*key, comparison.level.key))
            yield BoardRow(policy, places.get(policy), ratio, self.origins[key])

    @cached_property
    def _ratios(self) -> dict[tuple[str, str, str], RatioRow]:
        if DEFAULT_BASELINE not in self.results.policies:
            return {}
        rows = Ratios.of(self.results, [DEFAULT_BASELINE]).rows
        return {(row.scenario, row.policy, row.metric): row for row in rows}


def boards(parts: Sequence[tuple[str, Results]]) -> list[Board]:
    """Return a leaderboard for each part of a suite that the results are of, and for each other set of scenarios.

    Args:
        parts: the results with the names of their folders.

    Raises:
        InputError: the same policy or scenario differs in two of them, or nothing is complete.

    """
    found: dict[tuple[str, ...], list[tuple[str, Results]]] = {}
    for folder, results in parts:
        run = results.suite_run
        key = tuple(sorted(results.scenarios)) if run is None else (run.suite.name, run.part)
        found.setdefault(key, []).append((folder, results))
    return [_board(group) for group in found.values()]


def _board(group: Sequence[tuple[str, Results]]) -> Board:
    needed = _task_counts(group)
    kept: list[Results] = []
    origins: dict[tuple[str, str], Origin] = {}
    left_out: list[str] = []
    for folder, results in group:
        whole = [key for key, records in results.groups.items() if len(records) == needed[key[0]]]
        origins |= {key: Origin.of(results) for key in whole if key not in origins}
        left_out += [
            f"{folder}: {policy} is not listed for {scenario}, as it flew {len(records)} of {needed[scenario]} tasks"
            for (scenario, policy), records in results.groups.items()
            if len(records) != needed[scenario]
        ]
        kept += [_only(results, whole)] if whole else []
    if not kept:
        raise InputError(f"{left_out[0]}; fly the rest with the same command, without --maps")
    return Board(*_told(group[0][1]), combined(kept), origins, tuple(left_out))


def _task_counts(group: Sequence[tuple[str, Results]]) -> dict[str, int]:
    """Return how many tasks each scenario has: those of its suite, or all that anybody flew."""
    run, names = group[0][1].suite_run, {name for _, results in group for name in results.scenarios}
    if run is not None:
        return dict.fromkeys(names, run.total // len(run.suite.scenarios()))
    flown = {name: {task for _, results in group for task in results.tasks(name)} for name in names}
    return {name: len(tasks) for name, tasks in flown.items()}


def _told(results: Results) -> tuple[str, str]:
    """Return title and description of what was flown."""
    run = results.suite_run
    if run is not None:
        return f"{run.suite.title}, {run.part} part", run.suite.about
    seeds = sorted({record.task.seed for record in results.records})
    return f"{', '.join(results.scenarios)}: seeds {seeds[0]:,} to {seeds[-1]:,}", ""


def _only(results: Results, kept: Sequence[tuple[str, str]]) -> Results:
    """Return the results of these scenarios and policies."""
    scenarios, policies = ({key[place] for key in kept} for place in range(2))
    return replace(
        results,
        scenarios={name: results.scenarios[name] for name in results.scenarios if name in scenarios},
        policies={name: results.policies[name] for name in results.policies if name in policies},
        records=[each for each in results.records if (each.task.scenario, each.policy) in kept],
    )
