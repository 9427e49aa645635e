"""The local engine: batches of tasks on worker processes of this machine."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from typing import NamedTuple

from loky import ProcessPoolExecutor

from indoor_explorers.env import Scenario
from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.experiment import PolicyChoice, Task
from indoor_explorers.evaluation.record import Record
from indoor_explorers.evaluation.runner import fly

#: Every worker keeps to one thread: the processes are the parallelism.
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
#: Seconds between two looks of a worker at whether its driver still lives.
LOOK_EVERY = 0.5


class Job(NamedTuple):
    """A batch of episodes of one policy on one scenario."""

    policy: PolicyChoice
    scenario: Scenario
    tasks: tuple[Task, ...]


def fly_job(job: Job) -> list[Record]:
    """Fly a job in this process."""
    return list(fly(job.policy.make(), job.policy.name, job.scenario, job.tasks))


def fly_jobs(jobs: Sequence[Job], workers: int) -> Iterator[list[Record]]:
    """Yield the records of each job as it finishes; ``workers`` 0 flies them one by one in this process.

    The workers start as fresh interpreters that never import the caller's main module, so that a script
    needs no guard around its call.

    Raises:
        RunError: a worker process died; what was yielded before stays valid.
    """
    if workers == 0:
        yield from map(fly_job, jobs)
        return
    start = (os.getpid(),)
    pool = ProcessPoolExecutor(min(workers, len(jobs)), initializer=_prepare_worker, initargs=start, env=ONE_THREAD)
    try:
        yield from _as_completed(pool, jobs, in_flight=2 * workers)
    except BrokenProcessPool as error:
        raise RunError(
            "a worker process died before it finished its episodes (out of memory, or a policy ended it); "
            "the finished episodes are kept, and the same command goes on from there"
        ) from error
    finally:
        pool.shutdown(wait=True, kill_workers=True)


def _as_completed(pool: ProcessPoolExecutor, jobs: Sequence[Job], in_flight: int) -> Iterator[list[Record]]:
    """Keep a few jobs in flight, so that stopping early leaves little behind."""
    waiting = iter(jobs)
    running: set[Future[list[Record]]] = set()
    while True:
        while len(running) < in_flight and (job := next(waiting, None)) is not None:
            running.add(pool.submit(fly_job, job))
        if not running:
            return
        done, running = wait(running, return_when=FIRST_COMPLETED)
        for future in done:
            yield future.result()


def _prepare_worker(driver: int) -> None:
    """Leave Ctrl-C to the driver, and leave with it when it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with, args=(driver,), daemon=True).start()


def _leave_with(driver: int) -> None:
    while os.getppid() == driver:
        time.sleep(LOOK_EVERY)
    os._exit(1)
