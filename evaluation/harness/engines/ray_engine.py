"""The Ray engine: the jobs of a comparison on the cores of a cluster; CLUSTER.md says how to run one.

A job is a Ray task of one CPU. The driver, the process of the command, submits a bounded number of jobs and yields
their records as they come. When a node is lost, Ray repeats its running jobs and those whose results it held.
Ray: Moritz et al., "Ray: a distributed framework for emerging AI applications", OSDI 2018.
"""

from __future__ import annotations

import contextlib
import os
import socket
import sys
import time
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import ray
from ray.exceptions import RayError, RayTaskError

from indoor_explorers.env.errors import InputError, PolicyError, RunError
from indoor_explorers.env.maps.base import MapReader
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.provenance import versions
from indoor_explorers.evaluation.harness.engines.process_handle import ONE_THREAD
from indoor_explorers.evaluation.harness.engines.ray_connection import connected, cpus
from indoor_explorers.evaluation.harness.engines.supervisor import Supervisor
from indoor_explorers.evaluation.harness.engines.workload import Jobs
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode
from indoor_explorers.evaluation.harness.experiment.experiment import Job
from indoor_explorers.evaluation.harness.experiment.limits import DECISION_TIMEOUT, limits_for
from indoor_explorers.evaluation.harness.experiment.provenance import PACKAGES, source_digest

#: How often Ray repeats a job whose node or process was lost before the job counts as failed.
RETRIES = 3
#: Jobs in flight for each CPU: one flies, one waits, so that no CPU waits for the driver.
JOBS_PER_CPU = 2
#: Seconds between two counts of the cluster's CPUs.
COUNT_EVERY = 10.0
#: End of the message of a run that cannot go on.
KEPT = "the finished episodes are kept, and the same command goes on from there"


class Origin(NamedTuple):
    """The environment of the command, which a job needs on its node too."""

    folder: str
    """The working folder, from which relative paths in a policy's parameters are read."""
    paths: tuple[str, ...]
    """Python's search path for modules, with the working folder for ``module:Class`` plug-ins."""
    versions: tuple[tuple[str, str], ...]
    """Versions of the packages that results depend on, and a hash of this package's sources."""

    @classmethod
    def here(cls) -> Origin:
        """Return the origin of jobs of this process."""
        return cls(str(Path.cwd()), tuple(sys.path), _versions())


@lru_cache(maxsize=1)
def supervisor(decision_timeout: float | None, memory_limit: float | None) -> Supervisor:
    """Return the supervisor of this Ray worker: its jobs fly in a process of their own, as they do locally."""
    return Supervisor(limits_for(os.cpu_count() or 1, decision_timeout, memory_limit))


@lru_cache(maxsize=1)
def _versions() -> tuple[tuple[str, str], ...]:
    return tuple((versions(PACKAGES) | {"indoor-explorers' sources": source_digest()}).items())


@lru_cache(maxsize=1)
def prepare(origin: Origin) -> None:
    """Prepare this process for jobs of an origin: search path and working folder.

    Raises:
        InputError: other versions than those of the origin are installed here.
    """
    here = dict(_versions())
    differing = [f"{name} {here.get(name)}, not {there}" for name, there in origin.versions if here.get(name) != there]
    if differing:
        raise InputError(
            f"node {socket.gethostname()} has {', '.join(differing)}; install on every node what is installed here"
        )
    sys.path.extend(path for path in origin.paths if path not in sys.path)
    with contextlib.suppress(OSError):  # a node need not have the folder
        os.chdir(origin.folder)


def fly_on_node(
    origin: Origin, allowed: tuple[float | None, float | None], job: Job, *plans: Floorplan
) -> list[FlownEpisode]:
    """Fly a job on a node.

    Args:
        origin: What the job relies on.
        allowed: The arguments of :func:`supervisor`.
        job: What to fly.
        plans: The floor plans of its map files, in the order of their indices.
    """
    prepare(origin)
    maps = job.scenario.map
    if isinstance(maps, MapReader):
        held = maps.holding(dict(zip(_indices(job), plans, strict=True)))
        job = job._replace(scenario=job.scenario.model_copy(update={"map": held}))
    return supervisor(*allowed).fly(job)


def _indices(job: Job) -> list[int]:
    return sorted({task.map_index for task in job.tasks})


def fly_jobs_on_ray(
    jobs: Jobs,
    workers: int | None = None,
    address: str | None = None,
    decision_timeout: float | None = DECISION_TIMEOUT,
    memory_limit: float | None = None,
) -> Iterator[list[FlownEpisode]]:
    """Yield the records of each job as it finishes, from at most ``workers`` tasks at a time.

    Args:
        jobs: What to fly; map files are read here, so that nodes need none.
        workers: Tasks at a time, at least 1; None for all CPUs, counted anew as nodes come and go.
        address: ``host:port`` of a cluster's head; None for where Ray finds one (``RAY_ADDRESS``, a cluster that runs
            on this machine), or a cluster of this machine alone, started for these jobs. A process that has connected
            itself to a cluster uses that one, and stays connected.
        decision_timeout: Seconds that a decision may take; None for no limit.
        memory_limit: GB that a policy's process may use; None for an equal share of its node's memory.

    Raises:
        InputError: no cluster at that address, one without CPUs, or other versions on its nodes.
        RunError: a job failed after all retries; the other submitted jobs were yielded before.
    """
    with connected(address):
        queue = _JobQueue(workers, (decision_timeout, memory_limit))
        try:
            yield from queue.fly(jobs)
        finally:
            queue.cancel()


class _JobQueue:
    """Keeps a bounded number of jobs running on the cluster that this process is connected to."""

    def __init__(self, workers: int | None, allowed: tuple[float | None, float | None]) -> None:
        self._workers = workers
        self._allowed = allowed
        self._task = ray.remote(num_cpus=1, max_retries=RETRIES, runtime_env={"env_vars": ONE_THREAD})(fly_on_node)
        self._origin = ray.put(Origin.here())
        self._plans: dict[tuple[str, int], Any] = {}
        self._running: dict[Any, Job] = {}
        self._room, self._counted = 0, -COUNT_EVERY

    def fly(self, jobs: Jobs) -> Iterator[list[FlownEpisode]]:
        """Yield the records of each job as it finishes; raise the error of a failed one when the others are done."""
        waiting, failure = iter(jobs), None
        while True:
            while failure is None and self._has_room() and (job := next(waiting, None)) is not None:
                self._submit(job)
            if not self._running:
                break
            for ref in self._finished():
                try:
                    yield ray.get(ref)
                except RayError as error:
                    failure = failure or _failure(self._running[ref], error)
                del self._running[ref]
        if failure is not None:
            raise failure

    def cancel(self) -> None:
        """Cancel the jobs that are still running."""
        for ref in self._running:
            ray.cancel(ref, force=True)

    def _has_room(self) -> bool:
        if self._workers is not None:
            return len(self._running) < self._workers
        if time.monotonic() - self._counted > COUNT_EVERY:
            self._room, self._counted = max(1, JOBS_PER_CPU * cpus()), time.monotonic()
        return len(self._running) < self._room

    def _submit(self, job: Job) -> None:
        plans = [self._plan(job, index) for index in _indices(job)] if isinstance(job.scenario.map, MapReader) else []
        self._running[self._task.remote(self._origin, self._allowed, job, *plans)] = job

    def _plan(self, job: Job, index: int) -> Any:
        """Return the reference to a map file's floor plan in the object store, put there once."""
        key = (job.scenario.name, index)
        if key not in self._plans:
            self._plans[key] = ray.put(job.scenario.map.floorplan(index, 0))
        return self._plans[key]

    def _finished(self) -> list[Any]:
        """Wait until a job has finished; return all that have."""
        first, others = ray.wait(list(self._running), num_returns=1)
        more, _ = ray.wait(others, num_returns=len(others), timeout=0) if others else ([], [])
        return [*first, *more]


def _failure(job: Job, error: RayError) -> Exception:
    """Return what ends a run in which a job failed."""
    cause = error.cause if isinstance(error, RayTaskError) else error
    if isinstance(cause, InputError | PolicyError):
        return cause
    seeds = [task.seed for task in job.tasks]
    what = f"{job.policy.name} on {job.scenario.name}, seeds {min(seeds)} to {max(seeds)}"
    reason = " ".join(str(cause).split())[:300]
    return RunError(f"{what}: the job failed on the cluster, {type(cause).__name__}: {reason}; {KEPT}")
