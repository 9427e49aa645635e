"""Combines results about the same tasks; refuses others and names what differs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.reported.rows import joined
from indoor_explorers.evaluation.harness.results.fingerprints import comparable
from indoor_explorers.evaluation.harness.results.policy_version import differing_fields, version_difference
from indoor_explorers.evaluation.harness.results.results import Results

#: Settings of a scenario that do not change the task.
ASIDE = ("name", "fingerprint", "map.paths")


def combined(parts: Sequence[Results]) -> Results:
    """Return several results as one.

    Raises:
        InputError: scenarios, maps, seeds, policies or episodes of the same name differ; the message says in what.

    """
    for one, other in combinations(parts, 2):
        _refuse_unlike(one, other)
    whole, *others = sorted(parts, key=lambda part: not part.scenarios)  # reported rows alone come last
    for part in others:
        whole = _joined(whole, part)
    joined(whole.reported, whole.policies)
    return whole


def _joined(one: Results, other: Results) -> Results:
    held = {(record.policy, record.task) for record in one.records}
    return Results(
        one.policies | other.policies,
        one.scenarios | other.scenarios,
        one.runs + other.runs,
        one.records + [record for record in other.records if (record.policy, record.task) not in held],
        tuple(dict.fromkeys(one.experiments + other.experiments)),
        tuple(dict.fromkeys(one.notes + other.notes)),
        {**other.retries, **one.retries},
        margin=one.margin,
        plugins=one.plugins | other.plugins,
        reported=joined(one.reported + other.reported),
        origins={**other.origins, **one.origins},
    )


def _refuse_unlike(one: Results, other: Results) -> None:
    for name in (name for name in one.scenarios if name in other.scenarios):
        difference = scenario_difference(one, other, name)
        if difference:
            raise InputError(f"scenario {name!r} is not the same task in both results; what differs: {difference}")
        _refuse_other_seeds(one, other, name)
    for name in (name for name in one.policies if name in other.policies):
        what = version_difference(one.policies[name], other.policies[name])
        if what:
            raise InputError(
                f"policy {name!r} is not the same in both results; what differs: {what}; rename it in one of them"
            )
    _refuse_other_flights(one, other)


def scenario_difference(one: Results, other: Results, name: str) -> str:
    """Return how the tasks of a scenario differ between two results, with both values; empty if they do not.

    Beside the settings, the cells of the maps and the starts of the UAVs on common tasks are compared.
    """
    ours, theirs = one.scenarios[name], other.scenarios[name]
    same = ours["fingerprint"] == theirs["fingerprint"]
    fields = differing_fields(*(map(comparable, (ours, theirs)) if same else (ours, theirs)), aside=ASIDE)
    firsts, seconds = _by_task(one, name), _by_task(other, name)
    for task in sorted(firsts.keys() & seconds.keys()):
        what = _drawn_difference(firsts[task], seconds[task])
        if what:
            return "; ".join(filter(None, (fields, f"{what} of map {task.map_index}, seed {task.seed}")))
    return fields or ("" if same else "the cells of its maps")


def _by_task(results: Results, scenario: str) -> dict[Task, Record]:
    """Return one record of each task: all policies have the same map and starts."""
    return {
        record.task: record for (name, _), records in results.groups.items() if name == scenario for record in records
    }


def _drawn_difference(one: Record, other: Record) -> str:
    if one.floorplan.digest != other.floorplan.digest:
        return "the cells"
    if one.team == other.team and not np.array_equal(one.cells[0], other.cells[0]):
        return "the starts"
    return ""


def _refuse_other_seeds(one: Results, other: Results, name: str) -> None:
    ours, theirs = one.tasks(name), other.tasks(name)
    if ours != theirs:
        raise InputError(
            f"scenario {name!r} was not flown on the same seeds in both results ({_seeds(ours)} and {_seeds(theirs)}); "
            "finish both, with the same --seed and --episodes"
        )


def _seeds(tasks: set[Task]) -> str:
    if not tasks:
        return "none"
    seeds = [task.seed for task in tasks]
    return f"{min(seeds)} to {max(seeds)}, {len(tasks)} tasks"


def _refuse_other_flights(one: Results, other: Results) -> None:
    flown = {(record.policy, record.task): record for record in one.records}
    for record in other.records:
        before = flown.get((record.policy, record.task))
        if before is not None and not before.flew_like(record):
            task = record.task
            raise InputError(
                f"policy {record.policy!r} flew scenario {task.scenario!r}, map {task.map_index}, seed {task.seed} "
                f"differently in both results ({_ending(before)} at {_commits(one)}, {_ending(record)} at "
                f"{_commits(other)}); fly both again with one commit, or see what changed: report NEW --against OLD"
            )


def _ending(record: Record) -> str:
    return f"{record.steps} steps and {record.curve[-1]:.2%} coverage"


def _commits(results: Results) -> str:
    commits = dict.fromkeys(str(run.get("commit", "unknown")) for run in results.runs)
    return "commit " + " or ".join(commits or ["unknown"])
