"""The supervisor: flies jobs in a worker process and returns a record of every episode even if the process dies."""

from __future__ import annotations

import pickle
import sys
import threading
import weakref
from typing import Any, NamedTuple

from indoor_explorers.env.errors import RunError
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.harness.engines.process_handle import STARTS, ProcessExit, ProcessHandle
from indoor_explorers.evaluation.harness.engines.worker import serve
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode, Record
from indoor_explorers.evaluation.harness.episodes.running import RunningEpisode, simulated_record
from indoor_explorers.evaluation.harness.episodes.shared_memory import SharedStepBuffer
from indoor_explorers.evaluation.harness.episodes.steps import Steps
from indoor_explorers.evaluation.harness.experiment.experiment import Job, PolicyChoice
from indoor_explorers.evaluation.harness.experiment.limits import Limits


class WorkerHandle(ProcessHandle):
    """One worker process."""

    def __init__(self, limits: Limits) -> None:
        self._buffer = SharedStepBuffer()
        self._loaded = False
        """Whether it holds a policy from outside this package."""
        super().__init__(limits, self._buffer, serve, limits, longest=sys.maxsize)

    def send(self, job: Job) -> None:
        """Send a job, and clear the steps of the previous one; :meth:`receive` reports a dead worker."""
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
        """The worker and its descendants, without the process of an isolated policy, which has its own limit."""
        return super()._counted if self._loaded else {self._server or self._process.pid}

    def steps(self, team: int, base: bool = False) -> Steps:
        """Return the steps of the single episode that it flies or flew last, with a home base or not."""
        return self._buffer.steps(team, base)


__all__ = ["Limits", "Supervisor"]

CLOSED = "the supervisor of these workers was closed"


class _Attempt(NamedTuple):
    """The result of flying a job in a worker process."""

    records: list[FlownEpisode]
    """Records of all its tasks, or of those that were finished when the process ended."""
    exit: ProcessExit | None
    """How the process of the policy ended, None when the job was finished."""
    steps: Steps | None
    """The steps of the episode during which the process ended, if the job had only that one."""


class Supervisor:
    """Fly jobs in one worker process, and replace it when it dies, hangs or takes too much memory.

    The worker does the same to the process of an isolated policy, and reports how it ended.

    When a process dies in a job of several episodes, it is not known which of them was the cause. So those without a
    record are flown again one by one: episodes do not depend on their batch, and only the one at fault fails. An
    episode counts as failed only in a process that has flown nothing before, so that it is not blamed for what an
    earlier one left behind; and where the process was killed from outside, only when that happens a second time.

    A process that has loaded a policy from outside this package serves no other one, since such a policy may change
    modules that others use, on purpose or not. The package's own policies share a process.

    Safe to call from several threads; they take turns.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._turn = threading.Lock()
        self._closed = threading.Event()
        self._workers: list[WorkerHandle] = []
        self._loaded: PolicyChoice | None = None
        """The policy from outside this package that the worker process has loaded."""
        self.serves: PolicyChoice | None = None
        """The policy from outside this package that any of its processes has loaded."""
        weakref.finalize(self, _close_all, self._workers)

    def fly(self, job: Job) -> list[FlownEpisode]:
        """Return a record for every task of the job.

        Raises:
            InputError: the job cannot be flown with any policy, because of its settings.
            RunError: the worker failed for another reason, or the supervisor was closed meanwhile.

        """
        with self._turn:
            return self._fly_all(job)

    def close(self) -> None:
        """End the process; a running job raises a RunError."""
        self._closed.set()
        for worker in list(self._workers):
            worker.kill()
        with self._turn:
            _close_all(self._workers)

    def _fly_all(self, job: Job) -> list[FlownEpisode]:
        if len(job.tasks) == 1:
            return [self._fly_alone(job)]
        tried = self._try(job)
        held = {record.task for record in tried.records}
        alone = (job._replace(tasks=(task,)) for task in job.tasks if task not in held)
        return tried.records + [self._fly_alone(one) for one in alone]

    def _fly_alone(self, job: Job) -> FlownEpisode:
        exits = 0
        while True:
            tried = self._try(job)
            if tried.exit is None:
                return tried.records[0]
            exits += tried.exit.fresh
            if tried.steps is not None and exits >= 1 + tried.exit.from_outside:
                return _failed(job, tried.exit, tried.steps)

    def _try(self, job: Job) -> _Attempt:
        """Fly a job once, until it is finished or a process ends."""
        worker = self._worker(job)
        try:
            worker.send(job)
            records = []
            while isinstance(message := worker.receive(), FlownEpisode):
                records.append(message)
            if isinstance(message, ProcessExit) and not self._closed.is_set():
                steps = worker.steps(job.scenario.team, job.scenario.base.exists)
                if worker.ended:
                    self._discard(worker)
                return _Attempt(records, message, steps)
            if message is not None:
                raise RunError(CLOSED) if isinstance(message, ProcessExit) else message
        except BaseException:
            self._discard(worker)
            raise
        return _Attempt(records, None, None)

    def _worker(self, job: Job) -> WorkerHandle:
        """Return the worker process for a job; start one if there is none."""
        own = is_own_policy(job.policy.use)
        loads = None if own or job.isolated else job.policy
        if self._workers and self._loaded not in (None, loads):
            self._discard(self._workers[0])
            self.serves = None
        self._loaded = loads
        if not own or job.isolated:
            self.serves = None if own else job.policy
        if self._workers:
            return self._workers[0]
        for _ in range(STARTS):
            worker = WorkerHandle(self._limits)
            self._workers.append(worker)
            if self._closed.is_set():  # checked after the worker is listed: close() kills those listed
                self._discard(worker)
                raise RunError(CLOSED)
            if (ended := worker.receive()) is None:
                return worker
            self._discard(worker)
        raise RunError(f"a worker process cannot be started: {ended.reason}")

    def _discard(self, worker: WorkerHandle) -> None:
        """End a worker process."""
        worker.close()
        self._workers.remove(worker)


def _close_all(workers: list[WorkerHandle]) -> None:
    while workers:
        workers.pop().close()


def _failed(job: Job, ended: ProcessExit, steps: Steps) -> Record:
    (task,) = job.tasks
    floorplan = draw_floorplan(job.scenario, task.seed, task.map_index)
    flight = RunningEpisode(0, task, floorplan, job.bounds.get(task), failure=ended.reason)
    return simulated_record(flight, job.policy.name, job.scenario, steps)
