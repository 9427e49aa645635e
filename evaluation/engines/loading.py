"""The facts of a policy before it flies; code from outside this package is imported in a process of its own."""

from __future__ import annotations

import json
from typing import Any

from indoor_explorers.env import InputError
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.engines.worker import LOADING
from indoor_explorers.evaluation.engines.worker_handle import WorkerExit, ask_once
from indoor_explorers.evaluation.episodes.shared_clock import overdue_reason
from indoor_explorers.evaluation.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.experiment.limits import Limits
from indoor_explorers.evaluation.experiment.policy_facts import policy_facts


def load_facts(choice: PolicyChoice, limits: Limits | None) -> dict[str, Any]:
    """Return the facts of a policy, which is made once for this.

    One from outside this package is made in a process of its own with these ``limits``, so that nothing it does
    reaches this process; without limits it is made here.

    Raises:
        InputError: it cannot be imported or made, ends its process, takes too long, or tells something unusable.

    """
    if limits is None or is_own_policy(choice.use):
        return policy_facts(choice.make(), choice.use)
    answer = ask_once(choice, limits)
    if isinstance(answer, WorkerExit):
        raise InputError(_died(choice, answer, limits))
    if isinstance(answer, InputError):
        raise answer
    facts: dict[str, Any] = json.loads(answer)
    return facts


def _died(choice: PolicyChoice, ended: WorkerExit, limits: Limits) -> str:
    """Say what a policy did to the process that it was loaded in, and what to do about it."""
    limit = limits.decision_timeout
    if limit is not None and ended.reason == overdue_reason(limit):
        return f"policy {choice.name!r}: {overdue_reason(limit).replace('decision', LOADING, 1)}"
    return f"policy {choice.name!r}: {ended.reason} when it was imported and made; correct it or leave it out"
