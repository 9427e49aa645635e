"""The local engine: batches of tasks on worker processes of this machine, each with a supervisor."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from threading import Lock

from indoor_explorers.evaluation.engines.supervisor import Supervisor
from indoor_explorers.evaluation.engines.workload import Jobs
from indoor_explorers.evaluation.episodes.record import FlownEpisode, Record
from indoor_explorers.evaluation.episodes.runner import fly
from indoor_explorers.evaluation.experiment.experiment import Job
from indoor_explorers.evaluation.experiment.limits import Limits


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
    if workers == 0:
        yield from map(fly_job, jobs)
        return
    supervisors = [Supervisor(limits) for _ in range(min(workers, len(jobs)))]
    idle = list(supervisors)
    threads = ThreadPoolExecutor(len(supervisors), "engine")
    try:
        yield from _as_completed(threads, jobs, idle, in_flight=len(supervisors) + 1)
    finally:
        for supervisor in supervisors:
            supervisor.close()
        threads.shutdown(cancel_futures=True)


def _as_completed(
    threads: Executor, jobs: Jobs, idle: list[Supervisor], in_flight: int
) -> Iterator[list[FlownEpisode]]:
    """Keep a few jobs submitted at a time, so that little is lost by stopping early."""
    waiting = iter(jobs)
    choosing = Lock()
    running: set[Future[list[FlownEpisode]]] = set()
    while True:
        while len(running) < in_flight and (job := next(waiting, None)) is not None:
            running.add(threads.submit(_fly_with_idle, idle, choosing, job))
        if not running:
            return
        done, running = wait(running, return_when=FIRST_COMPLETED)
        for future in done:
            yield future.result()


def _fly_with_idle(idle: list[Supervisor], choosing: Lock, job: Job) -> list[FlownEpisode]:
    """Fly a job with a supervisor that is idle, if possible one whose process can go on; each thread finds one."""
    with choosing:
        supervisor = max(idle, key=lambda each: (each.serves == job.policy, each.serves is None))
        idle.remove(supervisor)
    try:
        return supervisor.fly(job)
    finally:
        idle.append(supervisor)
