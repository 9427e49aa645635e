"""The local engine: batches of tasks on worker processes of this machine, each with a supervisor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, ThreadPoolExecutor, wait
from threading import Lock
from typing import Self

from indoor_explorers.evaluation.harness.engines.supervisor import Supervisor
from indoor_explorers.evaluation.harness.engines.workload import Jobs, Workload
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode, Record
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Job
from indoor_explorers.evaluation.harness.experiment.limits import Limits


def fly_job(job: Job) -> list[Record]:
    """Fly a job in this process, without protection from a policy that hangs or ends its process."""
    return list(fly(job.policy.make(), job.policy.name, job.scenario, job.tasks, bounds=job.bounds))


def fly_jobs(jobs: Jobs, workers: int, limits: Limits) -> Iterator[list[FlownEpisode]]:
    """Yield the records of each job as it finishes; ``workers`` 0 flies them one by one in this process.

    The workers start as fresh interpreters that never import the caller's main module, so that a script
    needs no guard around its call.

    Raises:
        InputError: an episode cannot be flown with any policy, because of its settings.
        RunError: a worker cannot be started or failed for another reason; records yielded before stay valid.

    """
    with LocalWorkers(min(workers, len(jobs)), limits) as kept:
        yield from kept(jobs)


class LocalWorkers:
    """Worker processes for several runs in a row, which start when they are first needed; see :func:`fly_jobs`.

    Use as a context manager; 0 workers fly in this process.
    """

    def __init__(self, workers: int, limits: Limits) -> None:
        self._supervisors = [Supervisor(limits) for _ in range(workers)]

    def __call__(self, jobs: Jobs) -> Iterator[list[FlownEpisode]]:
        """Yield the records of each job as it finishes; the processes end if the run is broken off."""
        if not self._supervisors:
            yield from map(fly_job, jobs)
            return
        threads = ThreadPoolExecutor(len(self._supervisors), "engine")
        try:
            yield from _Dispatcher(self._supervisors, jobs).as_completed(threads)
        except BaseException:
            self.close()
            raise
        finally:
            threads.shutdown(cancel_futures=True)

    def close(self) -> None:
        """End the processes."""
        for supervisor in self._supervisors:
            supervisor.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class _Dispatcher:
    """Flies each job with a supervisor that is idle, if possible one whose processes have loaded its policy."""

    def __init__(self, supervisors: Sequence[Supervisor], jobs: Jobs) -> None:
        self._idle = list(supervisors)
        self._choosing = Lock()
        rest = iter(jobs)
        self._take = jobs.take if isinstance(jobs, Workload) else lambda loaded: next(rest, None)

    def as_completed(self, threads: Executor) -> Iterator[list[FlownEpisode]]:
        """Yield the records of each job; one job more is begun than was yielded, so that little is lost by stopping."""
        running = {threads.submit(self._fly_next) for _ in range(len(self._idle) + 1)}
        while running:
            done, running = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                if records := future.result():
                    yield records
                    running.add(threads.submit(self._fly_next))

    def _fly_next(self) -> list[FlownEpisode]:
        """Fly the next job; no records if there is none. Each thread finds an idle supervisor."""
        with self._choosing:
            job = self._take([each.serves for each in self._idle if each.serves is not None])
            if job is None:
                return []
            supervisor = max(self._idle, key=lambda each: (each.serves == job.policy, each.serves is None))
            self._idle.remove(supervisor)
        try:
            return supervisor.fly(job)
        finally:
            self._idle.append(supervisor)
