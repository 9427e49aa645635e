"""Verification of stored episodes: the world reproduces them from map, seed and actions, the policy its actions.

Code from outside this package that the results name is imported only if the user named it too.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from indoor_explorers.env import Scenario
from indoor_explorers.env.maps.base import MapReader
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.harness.engines.factory import make_engine
from indoor_explorers.evaluation.harness.engines.loading import PolicyLoader
from indoor_explorers.evaluation.harness.episodes.mismatch import mismatch
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.stored_names import refusal
from indoor_explorers.evaluation.harness.experiment.experiment import Job, PolicyChoice, episode_name
from indoor_explorers.evaluation.harness.experiment.limits import DECISION_TIMEOUT, limits_for
from indoor_explorers.evaluation.harness.results.policy_version import differing_fields, version_difference
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.stored_policy import (
    policy_entries,
    unmade_policies,
    whole_scenario,
)

#: Episodes for which another worker process is started.
TASKS_EACH = 20
#: Facts that a policy says of itself and that decide how it is marked.
FLAGS = ("uses_generator", "batched")
#: Facts that enter the hash of a policy; the hash is compared only where they are equal.
HASHED = ("parameters", "weights_for")


class Made(NamedTuple):
    """A policy that was made again."""

    choice: PolicyChoice
    facts: Mapping[str, Any]
    """What it says of itself now."""


def mismatches(results: Results) -> Iterator[str]:
    """Yield a line for each episode that is not what its map, seed and actions give."""
    scenarios = _scenarios(results)
    for record in (record for record in results.records if record.task.scenario in scenarios):
        scenario = scenarios[record.task.scenario]
        if not isinstance(scenario.map, MapReader) and _is_another_map(record, scenario):
            yield f"{episode_name(record.policy, record.task)}: not the map that the generator makes of its seed"
        elif fault := mismatch(record, scenario):
            yield f"{episode_name(record.policy, record.task)}: {fault}"


def made_again(results: Results) -> dict[str, Made]:
    """Make the policies as the stored experiment says, those from outside this package in processes of their own.

    :func:`unmade_policies` are left out.

    Raises:
        InputError: one cannot be imported or made.

    """
    entries, unmade = policy_entries(results), unmade_policies(results)
    choices = [validated(PolicyChoice, entries[name], "policy") for name in results.policies if name not in unmade]
    with PolicyLoader(limits_for(1, DECISION_TIMEOUT, None)) as loader:
        facts = loader.facts(choices)
    return {choice.name: Made(choice.by_present_names(facts[choice.name]), facts[choice.name]) for choice in choices}


def other_policies(results: Results, made: Mapping[str, Made]) -> list[str]:
    """Return a line for each policy that was made and is not the one stored."""
    found = {name: policy_difference(results.policies[name], made[name].facts) for name in made}
    return [f"{name}: the policy made is not the one stored: {what}" for name, what in found.items() if what]


def flown_differently(results: Results, count: int, made: Mapping[str, Made]) -> Iterator[str]:
    """Let policies that were made fly ``count`` of their episodes again, spread over the tasks, as in a comparison.

    Those from outside this package fly in processes of their own, which are given the true map only where the policy
    that was made needs it, whatever is stored.

    Yields:
        A line for each episode that differs.

    """
    stored = {(record.policy, record.task): record for record in results.records}
    scenarios, groups = _scenarios(results), results.groups.items()
    jobs = [
        _job(scenarios[name], records, made[policy], count)
        for (name, policy), records in groups
        if name in scenarios and policy in made
    ]
    workers = min(os.cpu_count() or 1, 1 + sum(len(job.tasks) for job in jobs) // TASKS_EACH)
    for records in make_engine("local", workers)(jobs) if jobs else ():
        for again in records:
            record = stored[again.policy, again.task]
            if not again.flew_like(record):
                yield f"{episode_name(record.policy, record.task)}: flown again, it took other actions"


def policy_difference(stored: Mapping[str, Any], made: Mapping[str, Any]) -> str:
    """Return in what a policy that was made differs from the facts stored about it, flags included."""
    alike = "hash" in stored and all(stored.get(name) == made.get(name) for name in HASHED)
    names = (*FLAGS, "hash") if alike else FLAGS
    one, other = ({name: facts.get(name) or False for name in names} for facts in (stored, made))
    return version_difference(stored, made) or differing_fields(one, other)


def _job(scenario: Scenario, records: Sequence[Record], made: Made, count: int) -> Job:
    """Return the flight of some episodes of a policy."""
    places = np.unique(np.linspace(0, len(records) - 1, min(count, len(records))).round().astype(int))
    tasks = tuple(records[place].task for place in places)
    isolated, bounds = not is_own_policy(made.choice.use), dict.fromkeys(tasks, 1)
    return Job(made.choice, scenario, tasks, bounds, isolated, isolated and made.facts["privileged"])


def _scenarios(results: Results) -> dict[str, Scenario]:
    """Return the stored scenarios by name, but for those that name code which the user did not."""
    known = [name for name, settings in results.scenarios.items() if not refusal(settings, results.plugins)]
    return {name: whole_scenario(results, name) for name in known}


def _is_another_map(record: Record, scenario: Scenario) -> bool:
    """Tell whether a map is not the one that the scenario's generator makes of the seed."""
    return draw_floorplan(scenario, record.task.seed, record.task.map_index).digest != record.floorplan.digest
