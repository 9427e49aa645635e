"""Driver-side handle of a worker process: sends it jobs and receives records."""

from __future__ import annotations

import pickle
import sys
from typing import Any

from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.harness.engines.process_handle import ProcessExit, ProcessHandle
from indoor_explorers.evaluation.harness.engines.worker import serve
from indoor_explorers.evaluation.harness.episodes.shared_steps import SharedStepBuffer
from indoor_explorers.evaluation.harness.episodes.steps import Steps
from indoor_explorers.evaluation.harness.experiment.experiment import Job
from indoor_explorers.evaluation.harness.experiment.limits import Limits


class WorkerHandle(ProcessHandle):
    """One worker process."""

    def __init__(self, limits: Limits) -> None:
        self._buffer = SharedStepBuffer()
        self._loaded = False
        """Whether it holds a policy from outside this package."""
        super().__init__(limits, self._buffer, serve, limits, longest=sys.maxsize)

    def send(self, job: Job) -> None:
        """Send a job, and clear the steps of the one before; a dead worker is ignored here."""
        self._jobs += 1
        self._buffer.begin()
        self._loaded |= not job.isolated and not is_own_policy(job.policy.use)
        self._channel.send(pickle.dumps(job, pickle.HIGHEST_PROTOCOL))

    def receive(self) -> Any:
        """Wait for its next message and return it, or its :class:`ProcessExit`; enforce the limits meanwhile."""
        message = self._await_message()
        return message if isinstance(message, ProcessExit) else pickle.loads(message)

    @property
    def _counted(self) -> set[int]:
        """It, with what a policy started there; the process of an isolated policy has a limit of its own."""
        return super()._counted if self._loaded else {self._server or self._process.pid}

    def steps(self, team: int, base: bool = False) -> Steps:
        """Return the steps of the single episode that it flies or flew last, with a home base or not."""
        return self._buffer.steps(team, base)
