"""Worker-side handle of the process of an isolated policy."""

from __future__ import annotations

import json
import pickle
import time
from typing import Any

from indoor_explorers.env.errors import RunError
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.harness.engines.policy_process import serve_policy
from indoor_explorers.evaluation.harness.engines.process_handle import STARTS, UNREADABLE, ProcessExit, ProcessHandle
from indoor_explorers.evaluation.harness.episodes.shared_memory import SharedViews
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.harness.experiment.limits import Limits


class ProcessEnded(Exception):
    """Reports that the process of a policy ended, or had to be killed."""

    def __init__(self, how: ProcessExit) -> None:
        super().__init__(how.reason)
        self.how = how


class PolicyHandle(ProcessHandle):
    """One process that holds a policy. Its answers are JSON, and are not trusted."""

    def __init__(self, limits: Limits) -> None:
        self.views = SharedViews()
        self.seconds = 0.0
        """Seconds from the latest question to its answer."""
        super().__init__(limits, self.views, serve_policy)

    @classmethod
    def started(cls, limits: Limits) -> PolicyHandle:
        """Start a process and wait until it serves.

        Raises:
            RunError: it cannot be started.

        """
        why = ""
        for _ in range(STARTS):
            process = cls(limits)
            try:
                process.answer()
            except ProcessEnded as ended:
                process.close()
                why = ended.how.reason
            else:
                return process
        raise RunError(f"the process of a policy cannot be started: {why}")

    def load(self, choice: PolicyChoice) -> Any:
        """Begin a job: have it make a policy; see :meth:`~.policy_process.PolicyServer.load`."""
        self._jobs += 1
        return self.ask("load", choice)

    def ask(self, question: str, *arguments: Any) -> Any:
        """Return the answer of a method of :class:`~.policy_process.PolicyServer`; enforce the limits meanwhile.

        Raises:
            ProcessEnded: the process ended, or was killed as it exceeded a limit.

        """
        first = arguments[0] if arguments else None
        # a decision for each UAV or episode, and one for what is deleted before
        self._stopwatch.ask(1 + (len(first) if isinstance(first, (list, dict)) else 1))
        asked = time.monotonic()
        self._channel.send(pickle.dumps((question, *arguments), pickle.HIGHEST_PROTOCOL))
        answer = self.answer()
        self.seconds = time.monotonic() - asked
        return answer

    def answer(self) -> Any:
        """Wait for the next answer; see :meth:`ask`."""
        message = self._await_message()
        if isinstance(message, ProcessExit):
            raise ProcessEnded(message)
        try:
            return json.loads(message)
        except (ValueError, RecursionError) as error:
            raise self.unreadable() from error

    def unreadable(self) -> ProcessEnded:
        """Kill the process because of an invalid answer; return the error to raise."""
        self.kill()
        return ProcessEnded(ProcessExit(UNREADABLE, fresh=self._jobs <= 1))


class PolicyHost:
    """Keeps one process for isolated policies; after a policy from outside this package it serves no other."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._process: PolicyHandle | None = None
        self._serves: PolicyChoice | None = None

    def process(self, choice: PolicyChoice) -> PolicyHandle:
        """Return the process for a policy; start one if there is none."""
        if self._serves not in (None, choice):
            self.discard()
        if self._process is None:
            self._process = PolicyHandle.started(self._limits)
        self._serves = None if is_own_policy(choice.use) else choice
        return self._process

    def discard(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.close()
        self._process = self._serves = None
