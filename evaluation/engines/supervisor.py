"""The supervisor: flies jobs in a process of their own, and still has a record of every episode when that dies."""

from __future__ import annotations

import threading
import weakref
from typing import NamedTuple

from indoor_explorers.env.errors import RunError
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.engines.limits import Limits
from indoor_explorers.evaluation.engines.worker_handle import Child, Death
from indoor_explorers.evaluation.episodes.record import Record
from indoor_explorers.evaluation.episodes.running import Flight, failed_record
from indoor_explorers.evaluation.episodes.shared_steps import Steps
from indoor_explorers.evaluation.experiment.experiment import Job

__all__ = ["Limits", "Supervisor"]

#: Processes that are started before it is given up.
STARTS = 3
CLOSED = "the supervisor of these workers was closed"


class _Attempt(NamedTuple):
    """What flying a job in the process gave."""

    records: list[Record]
    """Of all its tasks, or of those that were finished when the process ended."""
    death: Death | None
    """How it ended, None when all is well."""
    fresh: bool
    """Whether the process had flown nothing before."""
    steps: Steps | None
    """Those of the episode that it ended in, if that was flown alone."""


class Supervisor:
    """Fly jobs in one child process, and replace that when it dies, hangs or takes too much memory.

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
        self._children: list[Child] = []
        weakref.finalize(self, _close_all, self._children)

    def fly(self, job: Job) -> list[Record]:
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
        for child in list(self._children):
            child.kill()
        with self._turn:
            _close_all(self._children)

    def _fly_alone(self, job: Job) -> Record:
        deaths = 0
        while True:
            tried = self._try(job)
            if tried.death is None:
                return tried.records[0]
            deaths += tried.fresh
            if tried.steps is not None and deaths >= 1 + tried.death.from_outside:
                return _failed(job, tried.death, tried.steps)

    def _try(self, job: Job) -> _Attempt:
        """Fly a job once, as far as it goes."""
        child = self._child()
        fresh = child.fresh
        try:
            child.send(job)
            records = []
            while isinstance(message := child.hear(), Record):
                records.append(message)
            if isinstance(message, Death) and not self._closed.is_set():
                return _Attempt(records, message, fresh, self._buried(child, job.scenario.team))
            if message is not None:
                raise RunError(CLOSED) if isinstance(message, Death) else message
        except BaseException:
            self._buried(child, job.scenario.team)
            raise
        return _Attempt(records, None, fresh, None)

    def _child(self) -> Child:
        """Return the process, a new one where there is none."""
        if self._children:
            return self._children[0]
        for _ in range(STARTS):
            child = Child(self._limits)
            self._children.append(child)
            if self._closed.is_set():  # asked only now, as whoever closes kills the children that are listed by then
                self._buried(child, 1)
                raise RunError(CLOSED)
            if (death := child.hear()) is None:
                return child
            self._buried(child, 1)
        raise RunError(f"a worker process cannot be started: {death.reason}")

    def _buried(self, child: Child, team: int) -> Steps:
        """Let go of a process that is of no use any more; return the steps of the episode that it flew alone."""
        steps = child.steps(team)
        child.close()
        self._children.remove(child)
        return steps


def _close_all(children: list[Child]) -> None:
    while children:
        children.pop().close()


def _failed(job: Job, death: Death, steps: Steps) -> Record:
    (task,) = job.tasks
    floorplan = draw_floorplan(job.scenario, task.seed, task.map_index)
    flight = Flight(0, task, failure=death.reason)
    return failed_record(flight, job.policy.name, job.scenario, floorplan, steps)
