"""The leaderboard of a part of a suite: which results are complete, and the ranks of their policies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from indoor_explorers.env import InputError
from indoor_explorers.env.scenarios.suites.suite import Part, Suite
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
    """The complete results of a part of a suite."""

    suite: Suite
    part: Part
    results: Results
    origins: Mapping[tuple[str, str], Origin]
    """By scenario and policy."""
    left_out: tuple[str, ...]
    """A line for each policy and scenario of which episodes are missing."""

    @property
    def title(self) -> str:
        """Suite, version and part."""
        return f"{self.suite.title}, {self.part} part"

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
    """Return a leaderboard for each part of a suite that the results are of.

    Args:
        parts: the results with the names of their folders.

    Raises:
        InputError: results are of no suite, or the same policy differs in two of them.

    """
    found: dict[tuple[str, Part], list[tuple[str, Results]]] = {}
    for folder, results in parts:
        run = results.suite_run
        if run is None or not set(results.scenarios) <= {each.name for each in run.suite.scenarios()}:
            raise InputError(
                f"{folder}: expected results of one part of a suite, got other tasks; fly compare --suite NAME"
            )
        found.setdefault((run.suite.name, run.part), []).append((folder, results))
    return [_board(group) for group in found.values()]


def _board(group: Sequence[tuple[str, Results]]) -> Board:
    run = group[0][1].suite_run
    assert run is not None
    needed = run.total // len(run.suite.scenarios())
    kept: list[Results] = []
    origins: dict[tuple[str, str], Origin] = {}
    left_out: list[str] = []
    for folder, results in group:
        whole = [key for key, records in results.groups.items() if len(records) == needed]
        origins |= {key: Origin.of(results) for key in whole if key not in origins}
        left_out += [
            f"{folder}: {policy} is not listed for {scenario}, as it flew {len(records)} of {needed} tasks"
            for (scenario, policy), records in results.groups.items()
            if len(records) != needed
        ]
        kept += [_only(results, whole)] if whole else []
    if not kept:
        raise InputError(f"{left_out[0]}; fly the rest with the same command, without --maps")
    return Board(run.suite, run.part, combined(kept), origins, tuple(left_out))


def _only(results: Results, kept: Sequence[tuple[str, str]]) -> Results:
    """Return the results of these scenarios and policies."""
    scenarios, policies = ({key[place] for key in kept} for place in range(2))
    return replace(
        results,
        scenarios={name: results.scenarios[name] for name in results.scenarios if name in scenarios},
        policies={name: results.policies[name] for name in results.policies if name in policies},
        records=[each for each in results.records if (each.task.scenario, each.policy) in kept],
    )
