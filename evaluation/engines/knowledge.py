"""Checks plug-in policies for knowledge that they may not have, each in a process of its own."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.engines.worker import KnowledgeCheck
from indoor_explorers.evaluation.engines.worker_handle import ask_once
from indoor_explorers.evaluation.experiment.experiment import Experiment, PolicyChoice
from indoor_explorers.evaluation.experiment.limits import Limits, limits_for
from indoor_explorers.evaluation.results.policy_version import version_difference

#: Seconds after which a policy stays unchecked.
TIME_LIMIT = 10.0
#: Policies that are checked at the same time.
AT_ONCE = 2

Facts = dict[str, Any]


def with_failed_checks(
    experiment: Experiment, about: Mapping[str, Facts], stored: Mapping[str, Facts]
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
    different = {_key(choice): choice for choice in unknown}
    with ThreadPoolExecutor(AT_ONCE) as threads:
        answers = dict(zip(different, threads.map(_failed_check, different.values()), strict=True))
    found |= {
        choice.name: {"failed_check": answer} for choice in unknown if (answer := answers[_key(choice)]) is not None
    }
    return {name: facts | found.get(name, {}) for name, facts in about.items()}


def _key(choice: PolicyChoice) -> tuple[str, str]:
    """Return what policies under several names have in common."""
    return choice.use, repr(choice.parameters)


def _failed_check(choice: PolicyChoice) -> str | None:
    """Return which check a policy fails, empty for none; None if it takes too long or ends its process."""
    answer = ask_once(KnowledgeCheck(choice), Limits(TIME_LIMIT, limits_for(AT_ONCE, None, None).memory))
    return answer if isinstance(answer, str) else None
