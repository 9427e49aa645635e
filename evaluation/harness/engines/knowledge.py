"""Checks plug-in policies for knowledge that they may not have before they fly.

The checks are flown by this process; the policy decides in a process of its own, where nothing judges it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from indoor_explorers.env import InputError
from indoor_explorers.env.conformance import failed_check
from indoor_explorers.env.errors import PolicyError
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.harness.engines.loading import AT_ONCE, PolicyLoader
from indoor_explorers.evaluation.harness.engines.policy_handle import ProcessEnded
from indoor_explorers.evaluation.harness.engines.remote_policy import RemotePolicy
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, Job
from indoor_explorers.evaluation.harness.experiment.limits import Limits, limits_for
from indoor_explorers.evaluation.harness.results.policy_version import version_difference

#: Seconds of deciding after which a policy stays unchecked.
TIME_LIMIT = 10.0

Facts = dict[str, Any]


def with_failed_checks(
    experiment: Experiment, about: Mapping[str, Facts], stored: Mapping[str, Facts], loader: PolicyLoader
) -> dict[str, Facts]:
    """Return the facts of policies by name, those of plug-ins with the check for hidden knowledge that they fail.

    The fact ``failed_check`` is empty for a plug-in that passes, and missing for one that cannot be checked. A plug-in
    whose facts are ``stored`` is not checked again. The project's own policies and privileged ones are left out.
    """
    found = {
        name: {"failed_check": stored[name]["failed_check"]}
        for name, facts in about.items()
        if "failed_check" in stored.get(name, ()) and not version_difference(stored[name], facts)
    }
    unknown = [
        choice
        for choice in experiment.policies
        if choice.name not in found and not about[choice.name]["privileged"] and not is_own_policy(choice.use)
    ]
    answers = loader.of_each(
        unknown,
        lambda choice: _failed_check(loader, Job(choice, experiment.scenarios[0], ()), about[choice.name]),
    )
    found |= {
        choice.name: {"failed_check": answer}
        for choice, answer in zip(unknown, answers, strict=True)
        if answer is not None
    }
    return {name: facts | found.get(name, {}) for name, facts in about.items()}


def _failed_check(loader: PolicyLoader, job: Job, facts: Facts) -> str | None:
    """Return which check a policy fails, empty for none; None if it takes too long or ends its process."""
    limits = Limits(TIME_LIMIT, limits_for(AT_ONCE, None, None).memory)
    try:
        policy = RemotePolicy.of(loader.process(job.policy, limits), job, facts, TIME_LIMIT)
    except (ProcessEnded, InputError, PolicyError):
        return None
    found = failed_check(policy)
    return None if policy.ended or policy.unjudged else found
