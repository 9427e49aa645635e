"""Checks whether the policies are comparable: same tasks, complete, by the same program on the same machine."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.reported import all_reported
from indoor_explorers.evaluation.analysis.tables.policy_names import EXPOSED
from indoor_explorers.evaluation.drawing.formatting import counted, joined, percent
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.coverage_threshold import shared
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import FEWEST

#: Ratio of the largest to the smallest map in cells above which means in steps are doubtful.
UNLIKE = 3.0
#: Share of episodes that may be copies of others without a warning.
FEW_COPIES = 0.1


@dataclass(frozen=True)
class Verdict:
    """The result of the checks."""

    fine: bool
    """Whether there is no warning."""
    headline: str
    warnings: list[str]
    """What makes the comparison invalid or limited."""
    notes: list[str]
    """What else a reader should know."""


def _flown(results: Results, scenario: str) -> dict[str, set[Task]]:
    groups = results.groups.items()
    return {policy: {record.task for record in records} for (name, policy), records in groups if name == scenario}


def verdict_on(results: Results) -> Verdict:
    """Check all results, including tasks that not all policies flew."""
    copies, repeats = _copies(results)
    warnings = [
        *_missing(results), *_unlike(results), *copies, *_failed(results), *_failed_checks(results), *_few(results),
        *_sentences(results.map_notes), *_runs(results),
    ]  # fmt: skip
    notes = [
        *_buildings(results),
        *repeats,
        *_unlike_sizes(results),
        *_few_maps(results),
        *_privileged(results),
        *_aims(results),
        *_censored(results),
        *_sentences(results.seed_notes),
        *_unknown_code(results),
        *(f"{each.comparison.scenario}: {each.note}" for each in all_reported(results)),
    ]
    return Verdict(not warnings, _headline(results), warnings, notes)


def _headline(results: Results) -> str:
    number = len(results.policies)
    who = "Both policies" if number == 2 else f"All {number} policies" if number > 1 else "The only policy"
    tasks = [len(results.tasks(scenario)) for scenario in results.scenarios]
    if not results.records:
        return "Nothing has been flown yet."
    if any(True for _ in _missing(results)):
        common = sum(len(results.common_tasks(scenario)) for scenario in results.scenarios)
        return f"The policies did not fly the same tasks: {counted(common, 'task')} of {sum(tasks)} in common."
    same = " the same" if number > 1 else ""
    return f"{who} flew{same} {counted(sum(tasks), 'task')}: {_task_summary(results)}."


def _task_summary(results: Results) -> str:
    """Describe the tasks: scenarios, maps and seeds."""
    layouts = {_layout(results.tasks(scenario), results, scenario) for scenario in results.scenarios}
    each = layouts.pop() if len(layouts) == 1 else "maps and seeds as listed with each"
    number = len(results.scenarios)
    return each if number == 1 else f"{number} scenarios, each on {each}" if not layouts else f"{number} scenarios"


def _layout(tasks: set[Task], results: Results, scenario: str) -> str:
    maps = {r.floorplan.digest for r in results.records if r.task.scenario == scenario}
    seeds = {task.seed for task in tasks}
    if len(maps) == len(tasks) and len(maps) == len(seeds) > 1:
        return f"{counted(len(seeds), 'seed')}, every seed a map of its own"
    return f"{counted(len(maps), 'map')} with {counted(round(len(tasks) / max(1, len(maps))), 'seed')}" + (
        " each" if len(maps) > 1 else ""
    )


def _missing(results: Results) -> Iterator[str]:
    for scenario in results.scenarios:
        yield from missing_episodes(results, scenario)


def missing_episodes(results: Results, scenario: str) -> list[str]:
    """Name the policies that lack episodes of a scenario, and what is compared then; empty where there are none."""
    everything, flown = results.tasks(scenario), _flown(results, scenario)
    lacking = {name: len(everything) - len(flown.get(name, ())) for name in results.policies}
    listed = ", ".join(f"{name} lacks {number} of {len(everything)}" for name, number in lacking.items() if number)
    if not listed or not everything:
        return []
    common = len(results.common_tasks(scenario))
    rest = (
        f"only the {counted(common, 'task')} that all of these policies flew are compared"
        if common
        else "no task was flown by all, so the figures are about different tasks"
    )
    return [f"Missing episodes in {scenario}: {listed}; {rest}."]


def _unlike(results: Results) -> Iterator[str]:
    """Check that equal tasks had equal maps, starts, teams, budgets and denominators."""
    seen: dict[Task, tuple[object, ...]] = {}
    unlike: Counter[str] = Counter()
    for record in results.records:
        unlike[record.task.scenario] += seen.setdefault(record.task, _start(record)) != _start(record)
    for scenario, number in unlike.items():
        if number:
            yield (
                f"In {scenario}, {counted(number, 'episode')} started differently from another policy's episode with "
                "the same seed: the map, the starts, the team, the budget or the denominator differ."
            )


def _start(record: Record) -> tuple[object, ...]:
    return record.floorplan.digest, record.facts.start, record.team, record.budget, record.reachable


def _copies(results: Results) -> tuple[list[str], list[str]]:
    """Name the policies whose episodes repeat each other, as map and starts are the same and nothing is random.

    Returns warnings, where more than :data:`FEW_COPIES` are copies, and notes.
    """
    grave: defaultdict[tuple[str, int, int], list[str]] = defaultdict(list)
    slight: defaultdict[tuple[str, int, int], list[str]] = defaultdict(list)
    for (scenario, policy), records in results.groups.items():
        facts = results.facts(scenario, policy)
        flights = len({(record.floorplan.digest, fact.track) for record, fact in zip(records, facts, strict=True)})
        if flights < len(records):
            many = flights < (1 - FEW_COPIES) * len(records)
            (grave if many else slight)[scenario, len(records), flights].append(policy)
    return _copy_sentences(grave), _copy_sentences(slight)


def _copy_sentences(found: Mapping[tuple[str, int, int], Sequence[str]]) -> list[str]:
    """Return a sentence for all policies of a scenario with equally many different flights."""
    return [
        f"In {scenario}, the {counted(episodes, 'episode')} of {joined(policies)} are only "
        f"{counted(flights, 'different flight')}{' each' if len(policies) > 1 else ''}, as map and starts repeat; "
        "intervals and tests count them all."
        for (scenario, episodes, flights), policies in found.items()
    ]


def _failed(results: Results) -> Iterator[str]:
    counts = Counter(record.policy for record in results.records if record.outcome is Outcome.FAILED)
    if counts:
        failed = ", ".join(f"{name} in {counted(number, 'episode')}" for name, number in sorted(counts.items()))
        yield f"Failed policies: {failed}. Their coverage up to the failure counts."


def _failed_checks(results: Results) -> Iterator[str]:
    """Name the policies whose choices depend on what no UAV knows, or differ from flight to flight."""
    for name, text in results.failed_checks.items():
        yield (
            f"{name} failed the check {text}. It is not ranked: its figures may rest on what no UAV knows, or differ "
            "next time."
        )


def _few(results: Results) -> Iterator[str]:
    few = [name for name in results.scenarios if 0 < len(results.common_tasks(name)) < FEWEST]
    if few:
        where = "" if len(few) == len(results.scenarios) else f" in {', '.join(few)}"
        yield f"Fewer than {FEWEST} episodes a policy{where}: dots instead of intervals, and no tests."


def _runs(results: Results) -> Iterator[str]:
    """Warn of uncommitted changes, and name what differs between the runs."""
    if any("uncommitted" in str(run.get("commit", "")) for run in results.runs):
        yield "The source had uncommitted changes: the commit alone does not identify the code."
    yield from _sentences(results.warnings)


def _few_maps(results: Results) -> Iterator[str]:
    """Name the scenarios whose intervals hold for their own maps alone."""
    found: defaultdict[int, list[str]] = defaultdict(list)
    for name in results.scenarios:
        comparison = Comparison(results, name)
        if len(results.common_tasks(name)) >= FEWEST and not comparison.over_maps:
            found[comparison.map_count].append(name)
    for number, names in found.items():
        whose = "its" if len(names) == 1 else "their"
        which = f"{whose} one map" if number == 1 else f"{whose} {number} maps"
        yield f"Intervals of {', '.join(names)} hold for {which} alone, not for other maps of this kind."


def _unlike_sizes(results: Results) -> Iterator[str]:
    """Name the scenarios whose maps differ so much in size that the large ones dominate means in steps."""
    found: defaultdict[tuple[int, int], list[str]] = defaultdict(list)
    for name in results.scenarios:
        sizes = [record.reachable for record in results.records if record.task.scenario == name]
        if sizes and max(sizes) > UNLIKE * min(sizes):
            found[min(sizes), max(sizes)].append(name)
    for (smallest, largest), names in found.items():
        yield (
            f"The maps of {', '.join(names)} have {smallest} to {largest} cells to cover: the large ones dominate "
            "means in steps; ranks, wins, profiles and AUC weigh all maps alike."
        )


def _privileged(results: Results) -> Iterator[str]:
    groups = {
        "Privileged policies, which are given the true map and are not ranked": results.privileged_policies,
        "Policies that read the settings of the random generator that draws the maps, never the map": (
            results.generator_policies
        ),
        f"Policies from outside this package that {EXPOSED}": results.exposed_policies,
        "Policies that decide for many UAVs at once, whose decision times are shares of a batch": (
            results.batched_policies
        ),
    }
    yield from (f"{text}: {', '.join(names)}." for text, names in groups.items() if names)


def _aims(results: Results) -> Iterator[str]:
    """Name what policies plan for, where it differs or a time on the way to it is compared."""
    aims, below = results.aims, any(level.key != "t99" for level in results.levels)
    if set(aims) != {"not stated"} and (len(aims) > 1 or below):
        listed = "; ".join(f"{aim} by {', '.join(names)}" for aim, names in aims.items())
        yield f"What policies optimise: {listed}. Compare times to lower thresholds with this in mind."


def _unknown_code(results: Results) -> Iterator[str]:
    if results.policies_of_unknown_code:
        names = ", ".join(results.policies_of_unknown_code)
        yield f"The code behind {names} is unknown: no hashes of its sources were stored."


def _sentences(notes: Sequence[str]) -> list[str]:
    return [f"{text[0].upper()}{text[1:]}." for text in notes]


def _buildings(results: Results) -> Iterator[str]:
    """Name the scenarios in which maps of one building or layout count as one."""
    comparisons = [Comparison(results, name) for name in results.scenarios]
    alike = {each.maps_flown for each in comparisons if each.unit_count < each.map_count}
    units = " or ".join(unit for unit in ("building", "layout") if any(unit in maps for maps in alike))
    if alike:
        yield f"Intervals and tests count maps of one {units} as one, as they are alike: {', '.join(sorted(alike))}."


def _censored(results: Results) -> Iterator[str]:
    shares = {}
    for name in results.policies:
        records = (record for record in results.records if record.policy == name)
        late = [record.metrics.get(results.level(record.task.scenario).key) is None for record in records]
        if any(late):
            shares[name] = float(np.mean(late))
    if shares:
        listed = ", ".join(f"{name} {percent(share)}" for name, share in sorted(shares.items(), key=lambda s: -s[1]))
        level = shared(results.levels)
        what = level.percent if level else "the threshold of their scenario"
        yield f"Episodes that never reached {what} count with the whole budget, which is a lower bound: {listed}."
