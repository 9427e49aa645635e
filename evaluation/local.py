"""The local engine: batches of tasks on worker processes of this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import NamedTuple

from indoor_explorers.env import Scenario
from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.experiment import PolicyChoice, Task
from indoor_explorers.evaluation.record import Record
from indoor_explorers.evaluation.runner import fly


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

    Raises:
        RunError: a worker process died; what was yielded before stays valid.

    """
    if workers == 0:
        yield from map(fly_job, jobs)
        return
    pool = ProcessPoolExecutor(min(workers, len(jobs)), _context(), initializer=_prepare_worker)
    try:
        yield from _as_completed(pool, list(jobs), in_flight=2 * workers)
    except BrokenProcessPool as error:
        raise RunError(
            "a worker process died before it finished its episodes (out of memory, or a policy ended it); "
            "the finished episodes are kept, and the same command goes on from there"
        ) from error
    finally:
        _end(pool)


def _as_completed(pool: ProcessPoolExecutor, jobs: list[Job], in_flight: int) -> Iterator[list[Record]]:
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


def _end(pool: ProcessPoolExecutor) -> None:
    """Stop the workers at once: what they have not handed over is flown again by the next run."""
    processes = list((pool._processes or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.terminate()


def _context() -> multiprocessing.context.BaseContext:
    """Fork from a clean server that has the world imported, where the system can; it has no threads to lose."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([fly.__module__])
    return context


def _prepare_worker() -> None:
    """Leave Ctrl-C to the driver, leave with it when it is killed, and keep to one thread.

    The processes are the parallelism.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with_the_driver, daemon=True).start()
    for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[name] = "1"


def _leave_with_the_driver() -> None:
    driver = multiprocessing.parent_process()
    if driver is not None:
        driver.join()
        os._exit(1)
