"""Loads policies before they fly; code from outside this package is imported in a process of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Self, TypeVar

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import LONGEST, one_line
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.harness.engines.policy_handle import PolicyHandle, ProcessEnded
from indoor_explorers.evaluation.harness.engines.policy_process import LOADING
from indoor_explorers.evaluation.harness.engines.process_handle import ProcessExit
from indoor_explorers.evaluation.harness.episodes.shared_memory import overdue_reason
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.harness.experiment.limits import Limits
from indoor_explorers.evaluation.harness.experiment.policy_facts import checked_facts, policy_facts

#: Policies that are asked at the same time.
AT_ONCE = 2
#: Identity of a policy, which may have several names in results.
Key = tuple[str, str]
Answer = TypeVar("Answer")


class PolicyLoader:
    """Asks policies questions before they fly, several at a time; use as a context manager.

    A policy from outside this package is made in a process of its own, which answers all questions about it. Without
    limits, all are made in this process.
    """

    def __init__(self, limits: Limits | None) -> None:
        self._limits = limits
        self._processes: dict[Key, PolicyHandle] = {}
        self._threads = ThreadPoolExecutor(AT_ONCE, "loader")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """End the processes and the threads that wait for them; no question is possible after that."""
        for process in list(self._processes.values()):
            process.kill()
        self._threads.shutdown(cancel_futures=True)
        while self._processes:
            self._processes.popitem()[1].close()

    def facts(self, choices: Sequence[PolicyChoice]) -> dict[str, dict[str, Any]]:
        """Return the facts of policies by name; each is made once for this.

        Raises:
            InputError: a policy cannot be imported or made, ends its process, takes too long, or has invalid facts.

        """
        return dict(zip((choice.name for choice in choices), self.of_each(choices, self._facts), strict=True))

    def of_each(self, choices: Sequence[PolicyChoice], ask: Callable[[PolicyChoice], Answer]) -> list[Answer]:
        """Return the result of ``ask`` for each policy; policies of one identity are asked once."""
        different: dict[Key, PolicyChoice] = {}
        for choice in choices:
            different.setdefault(key_of(choice), choice)
        answers = dict(zip(different, self._threads.map(ask, different.values()), strict=True))
        return [answers[key_of(choice)] for choice in choices]

    def process(self, choice: PolicyChoice, limits: Limits) -> PolicyHandle:
        """Return the process of a policy, with these limits from now on; start one if there is none."""
        found = self._processes.get(key_of(choice))
        if found is None or found.ended:
            found = self._processes[key_of(choice)] = PolicyHandle.started(limits)
        found.limits = limits
        return found

    def _facts(self, choice: PolicyChoice) -> dict[str, Any]:
        if self._limits is None or is_own_policy(choice.use):
            return policy_facts(choice.make(), choice.use)
        try:
            answer = self.process(choice, self._limits).ask("facts", choice)
        except ProcessEnded as ended:
            raise InputError(_died(choice, ended.how, self._limits)) from ended
        reply = answer if isinstance(answer, dict) else {}
        if isinstance(refused := reply.get("refused"), str):
            raise InputError(one_line(refused, 3 * LONGEST))
        try:
            return checked_facts(reply.get("facts"), choice.use)
        except InputError as error:
            raise InputError(f"policy {choice.name!r}: {error}; correct it or leave it out") from error


def key_of(choice: PolicyChoice) -> Key:
    """Return the identity of a policy."""
    return choice.use, repr(choice.parameters)


def _died(choice: PolicyChoice, ended: ProcessExit, limits: Limits) -> str:
    """Say how a policy ended the process that loaded it, and how to mend that."""
    limit = limits.decision_timeout
    if limit is not None and ended.reason == overdue_reason(limit):
        return f"policy {choice.name!r}: {overdue_reason(limit).replace('decision', LOADING, 1)}"
    return f"policy {choice.name!r}: {ended.reason} when it was imported and made; correct it or leave it out"
