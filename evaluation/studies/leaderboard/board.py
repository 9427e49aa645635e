"""The leaderboard of a part of a suite, or of other tasks: which results are complete, and the ranks of policies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.ranks import Rank, ranks
from indoor_explorers.evaluation.harness.episodes.stored_names import refusal
from indoor_explorers.evaluation.harness.experiment.selection import DEFAULT_BASELINE
from indoor_explorers.evaluation.harness.reported.rows import joined
from indoor_explorers.evaluation.harness.results.combine import combined, scenario_difference
from indoor_explorers.evaluation.harness.results.ratios import RatioRow, Ratios
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.stored_policy import unmade_policies

#: Results with the name of their folder.
Part = tuple[str, Results]


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
                tuple(dict.fromkeys(values))
                for values in (
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
    """Description of the tasks; empty without a suite."""
    results: Results
    origins: Mapping[tuple[str, str], Origin]
    """By scenario and policy."""
    left_out: tuple[str, ...]
    """A line for each scenario that is not verified, policy that is not flown again, and flight that is incomplete."""
    fly: int
    """How many episodes of each scenario the policies fly again."""

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


def boards(parts: Sequence[Part], fly: int = 0) -> list[Board]:
    """Return a leaderboard for each part of a suite that the results are of, and for each other set of scenarios.

    Args:
        parts: the results with the names of their folders.
        fly: how many episodes of each scenario the policies fly again.

    Raises:
        InputError: the same policy or scenario differs in two of them, or nothing is complete.

    """
    found: dict[tuple[str, ...], list[Part]] = {}
    reported = joined(policy for _, results in parts for policy in results.reported)
    flown = [(folder, results) for folder, results in parts if results.scenarios or not results.reported]
    if not flown:
        raise InputError(
            f"{parts[0][0]}: expected flown results to rank, got reported rows alone; add a folder of them"
        )
    for folder, results in flown:
        run = results.suite_run
        key = tuple(sorted(results.scenarios)) if run is None else (run.suite.name, run.part)
        found.setdefault(key, []).append((folder, results))
    of_no_suite = [group for group in found.values() if group[0][1].suite_run is None]
    for group, another in combinations(of_no_suite, 2):
        for one, other in product(group, another):
            _refuse_one_title(one, other)
    made = [_board([(folder, replace(each, reported=())) for folder, each in group], fly) for group in found.values()]
    return [
        replace(each, results=replace(each.results, reported=joined(reported, each.results.policies))) for each in made
    ]


def _refuse_one_title(one: Part, other: Part) -> None:
    """Refuse different tasks under one title."""
    (folder, ours), (another, theirs) = one, other
    for name in (name for name in ours.scenarios if name in theirs.scenarios):
        difference = scenario_difference(ours, theirs, name)
        if difference and ours.title(name) == theirs.title(name):
            raise InputError(
                f"scenario {name!r} is not the same task in {folder} and {another}; what differs: {difference}; "
                "rename it in one of them, or rank them apart"
            )


def _board(group: Sequence[Part], fly: int) -> Board:
    needed = _task_counts(group)
    kept: list[Results] = []
    origins: dict[tuple[str, str], Origin] = {}
    unknown, incomplete = [], []
    for folder, results in group:
        refused = {
            name: why for name in results.scenarios if (why := refusal(results.scenarios[name], results.plugins))
        }
        flown = {key: len(records) for key, records in results.groups.items() if key[0] not in refused}
        whole = [key for key, count in flown.items() if count == needed[key[0]]]
        origins |= {key: Origin.of(results) for key in whole if key not in origins}
        unknown += [f"{folder}: {name} is not listed, as it cannot be verified: {why}" for name, why in refused.items()]
        incomplete += [
            f"{folder}: {policy} is not listed for {scenario}, as it flew {count} of {needed[scenario]} tasks"
            for (scenario, policy), count in flown.items()
            if count != needed[scenario]
        ]
        kept += [_only(results, whole)] if whole else []
    if not kept:
        raise InputError(
            unknown[0] if unknown else f"{incomplete[0]}; fly the rest with the same command, without --maps"
        )
    unflown = [
        f"{folder}: {name} was not flown again, and is what its folder says: {why}"
        for folder, results in (group if fly else ())
        for name, why in unmade_policies(results).items()
    ]
    return Board(*_title_and_description(group[0][1]), combined(kept), origins, (*unknown, *incomplete, *unflown), fly)


def _task_counts(group: Sequence[Part]) -> dict[str, int]:
    """Return how many tasks each scenario has: the tasks of its suite, or all tasks flown by any policy."""
    run, names = group[0][1].suite_run, {name for _, results in group for name in results.scenarios}
    if run is not None:
        return dict.fromkeys(names, run.total // len(run.suite.scenarios()))
    flown = {name: {task for _, results in group for task in results.tasks(name)} for name in names}
    return {name: len(tasks) for name, tasks in flown.items()}


def _title_and_description(results: Results) -> tuple[str, str]:
    """Return title and description of what was flown."""
    run = results.suite_run
    if run is not None:
        return f"{run.suite.title}, {run.part} part", run.suite.about
    seeds = sorted({record.task.seed for record in results.records})
    return f"{', '.join(map(results.title, results.scenarios))}: seeds {seeds[0]:,} to {seeds[-1]:,}", ""


def _only(results: Results, kept: Sequence[tuple[str, str]]) -> Results:
    """Return the results of these scenarios and policies."""
    scenarios, policies = ({key[place] for key in kept} for place in range(2))
    return replace(
        results,
        scenarios={name: results.scenarios[name] for name in results.scenarios if name in scenarios},
        policies={name: results.policies[name] for name in results.policies if name in policies},
        records=[each for each in results.records if (each.task.scenario, each.policy) in kept],
    )
