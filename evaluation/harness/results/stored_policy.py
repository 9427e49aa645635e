"""Policies and whole scenarios made again from results, which are untrusted data (:mod:`~..episodes.stored_names`)."""

from __future__ import annotations

import tomllib
from typing import Any

from indoor_explorers.env import InputError, Policy, Scenario
from indoor_explorers.env.maps.base import MapReader
from indoor_explorers.env.maps.sources import map_class
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.harness.episodes.stored_names import policy_refusal, refusal
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts
from indoor_explorers.evaluation.harness.results.policy_version import version_difference
from indoor_explorers.evaluation.harness.results.results import Results

#: Why a policy is not made whose experiment is not there.
NOT_TOLD = "no run tells how it was made"


def policy_entries(results: Results) -> dict[str, dict[str, Any]]:
    """Return how policies were made by name, from the experiments of the results."""
    return {entry["name"]: entry for text in results.experiments for entry in tomllib.loads(text)["policies"]}


def unmade_policies(results: Results) -> dict[str, str]:
    """Return why policies are not made here, by name: code from outside that the user did not name."""
    refused = {name: policy_refusal(entry, results.plugins) for name, entry in policy_entries(results).items()}
    return {name: why for name in results.policies if (why := refused.get(name, NOT_TOLD))}


def policy_again(results: Results, name: str) -> Policy:
    """Make a policy in this process as the results say.

    Raises:
        InputError: it may not or cannot be made, or is not the one stored.

    """
    entry = policy_entries(results).get(name)
    if entry is None:
        raise InputError(NOT_TOLD)
    if why := policy_refusal(entry, results.plugins):
        raise InputError(why)
    choice = validated(PolicyChoice, entry, "policy")
    policy = choice.make()
    if difference := version_difference(results.policies[name], policy_facts(policy, choice.use)):
        raise InputError(f"the policy made is not the one stored: {difference}")
    return policy


def whole_scenario(results: Results, name: str) -> Scenario:
    """Return a stored scenario with its maps; files are those that were flown on, and are not read.

    Raises:
        InputError: it is no scenario, or names code from outside this package that the user did not name.

    """
    if why := refusal(results.scenarios[name], results.plugins):
        raise InputError(f"stored scenario {name!r}: {why}")
    stored = results.scenarios[name]["map"]
    kind = map_class(stored["source"])
    if kind is None:
        raise InputError(f"scenario {name!r}: unknown source of maps {stored['source']!r}")
    maps = validated(kind, {key: value for key, value in stored.items() if key in kind.model_fields}, name)
    if isinstance(maps, MapReader):
        flown = {record.task.map_index: record.floorplan for record in results.records if record.task.scenario == name}
        maps = maps.holding(flown)
    return results.scenario(name).model_copy(update={"map": maps})
