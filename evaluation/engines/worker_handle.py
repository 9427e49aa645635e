"""A worker process as its driver sees it: it is sent jobs and sends back records."""

from __future__ import annotations

import contextlib
from typing import Any

from indoor_explorers.evaluation.engines.process_handle import ProcessHandle
from indoor_explorers.evaluation.engines.worker import serve
from indoor_explorers.evaluation.episodes.shared_steps import SharedStepBuffer
from indoor_explorers.evaluation.episodes.steps import Steps
from indoor_explorers.evaluation.experiment.experiment import Job
from indoor_explorers.evaluation.experiment.limits import Limits


class WorkerHandle(ProcessHandle):
    """One worker process."""

    def __init__(self, limits: Limits) -> None:
        self._buffer = SharedStepBuffer()
        super().__init__(limits, self._buffer, serve, limits)

    def send(self, job: Job) -> None:
        """Send a job, and clear the steps of the one before; a dead worker is ignored here."""
        self._jobs += 1
        self._buffer.begin()
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            self._connection.send(job)

    def receive(self) -> Any:
        """Wait for its next message and return it, or its :class:`ProcessExit`; enforce the limits meanwhile."""
        if (ended := self._await_message()) is not None:
            return ended
        try:
            return self._connection.recv()
        except (EOFError, ConnectionResetError):
            return self._exit()

    def steps(self, team: int, base: bool = False) -> Steps:
        """Return the steps of the single episode that it flies or flew last, with a home base or not."""
        return self._buffer.steps(team, base)
