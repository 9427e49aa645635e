"""The supervisor: flies jobs in a process of their own, and still has a record of every episode when that dies."""

from __future__ import annotations

import threading
import weakref
from typing import NamedTuple

from indoor_explorers.env.errors import RunError
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.engines.worker_handle import WorkerExit, WorkerHandle
from indoor_explorers.evaluation.episodes.record import FlownEpisode, Record
from indoor_explorers.evaluation.episodes.running import RunningEpisode, failed_record
from indoor_explorers.evaluation.episodes.steps import Steps
from indoor_explorers.evaluation.experiment.experiment import Job
from indoor_explorers.evaluation.experiment.limits import Limits

__all__ = ["Limits", "Supervisor"]

#: Processes that are started before it is given up.
STARTS = 3
CLOSED = "the supervisor of these workers was closed"


class _Attempt(NamedTuple):
    """What flying a job in the process gave."""

    records: list[FlownEpisode]
    """Of all its tasks, or of those that were finished when the process ended."""
    exit: WorkerExit | None
    """How it ended, None when all is well."""
    fresh: bool
    """Whether the process had flown nothing before."""
    steps: Steps | None
    """Those of the episode that it ended in, if that was flown alone."""


class Supervisor:
    """Fly jobs in one worker process, and replace that when it dies, hangs or takes too much memory.

    Of a job of several episodes nobody knows which one the process died of. So those without a record are flown again
    one by one: episodes do not depend on their batch, and the guilty ones fail alone. An episode fails only in a
    process that has flown nothing before, so that nothing that an earlier one left behind is put down to it; and if
    the process was killed from outside, which may be chance, only when that happens a second time.

    Several threads may call; they take turns.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._turn = threading.Lock()
        self._closed = threading.Event()
        self._workers: list[WorkerHandle] = []
        weakref.finalize(self, _close_all, self._workers)

    def fly(self, job: Job) -> list[FlownEpisode]:
        """Return a record for every task of the job.

        Raises:
            InputError: the job cannot be flown as it is, whatever the policy does.
            RunError: the same for reasons of the program's, or the supervisor was closed meanwhile.

        """
        with self._turn:
            if len(job.tasks) == 1:
                return [self._fly_alone(job)]
            tried = self._try(job)
            held = {record.task for record in tried.records}
            alone = (job._replace(tasks=(task,)) for task in job.tasks if task not in held)
            return tried.records + [self._fly_alone(one) for one in alone]

    def close(self) -> None:
        """End the process; a job that is being flown ends with a RunError."""
        self._closed.set()
        for worker in list(self._workers):
            worker.kill()
        with self._turn:
            _close_all(self._workers)

    def _fly_alone(self, job: Job) -> FlownEpisode:
        exits = 0
        while True:
            tried = self._try(job)
            if tried.exit is None:
                return tried.records[0]
            exits += tried.fresh
            if tried.steps is not None and exits >= 1 + tried.exit.from_outside:
                return _failed(job, tried.exit, tried.steps)

    def _try(self, job: Job) -> _Attempt:
        """Fly a job once, as far as it goes."""
        worker = self._worker()
        fresh = worker.fresh
        try:
            worker.send(job)
            records = []
            while isinstance(message := worker.hear(), FlownEpisode):
                records.append(message)
            if isinstance(message, WorkerExit) and not self._closed.is_set():
                return _Attempt(records, message, fresh, self._discard(worker, job.scenario.team))
            if message is not None:
                raise RunError(CLOSED) if isinstance(message, WorkerExit) else message
        except BaseException:
            self._discard(worker, job.scenario.team)
            raise
        return _Attempt(records, None, fresh, None)

    def _worker(self) -> WorkerHandle:
        """Return the process, a new one where there is none."""
        if self._workers:
            return self._workers[0]
        for _ in range(STARTS):
            worker = WorkerHandle(self._limits)
            self._workers.append(worker)
            if self._closed.is_set():  # asked only now, as whoever closes kills the workers that are listed by then
                self._discard(worker, 1)
                raise RunError(CLOSED)
            if (ended := worker.hear()) is None:
                return worker
            self._discard(worker, 1)
        raise RunError(f"a worker process cannot be started: {ended.reason}")

    def _discard(self, worker: WorkerHandle, team: int) -> Steps:
        """Let go of a process that is of no use any more; return the steps of the episode that it flew alone."""
        steps = worker.steps(team)
        worker.close()
        self._workers.remove(worker)
        return steps


def _close_all(workers: list[WorkerHandle]) -> None:
    while workers:
        workers.pop().close()


def _failed(job: Job, ended: WorkerExit, steps: Steps) -> Record:
    (task,) = job.tasks
    floorplan = draw_floorplan(job.scenario, task.seed, task.map_index)
    flight = RunningEpisode(0, task, floorplan, job.bounds.get(task), failure=ended.reason)
    return failed_record(flight, job.policy.name, job.scenario, steps)
