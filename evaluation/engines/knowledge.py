"""Checks plug-in policies for knowledge that they may not have, each in a process of its own."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.engines.loading import AT_ONCE, PolicyLoader
from indoor_explorers.evaluation.engines.policy_handle import ProcessEnded
from indoor_explorers.evaluation.experiment.experiment import Experiment, PolicyChoice
from indoor_explorers.evaluation.experiment.limits import Limits, limits_for
from indoor_explorers.evaluation.results.policy_version import version_difference

#: Seconds after which a policy stays unchecked.
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
    answers = loader.of_each(unknown, partial(_failed_check, loader))
    found |= {
        choice.name: {"failed_check": answer}
        for choice, answer in zip(unknown, answers, strict=True)
        if answer is not None
    }
    return {name: facts | found.get(name, {}) for name, facts in about.items()}


def _failed_check(loader: PolicyLoader, choice: PolicyChoice) -> str | None:
    """Return which check a policy fails, empty for none; None if it takes too long or ends its process."""
    limits = Limits(TIME_LIMIT, limits_for(AT_ONCE, None, None).memory)
    try:
        answer = loader.process(choice, limits).ask("failed_check", choice)
    except ProcessEnded:
        return None
    return answer if isinstance(answer, str) else None
