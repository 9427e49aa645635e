"""Makes the engine that flies the episodes: worker processes of this machine, or a Ray cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import partial

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.harness.engines.local import LocalWorkers, fly_jobs
from indoor_explorers.evaluation.harness.engines.workload import Jobs
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode
from indoor_explorers.evaluation.harness.experiment.limits import DECISION_TIMEOUT, limits_for
from indoor_explorers.evaluation.harness.experiment.request import ENGINES

#: Flies jobs and yields the records of each as it finishes, in any order.
Engine = Callable[[Jobs], Iterator[list[FlownEpisode]]]


def make_engine(
    name: str,
    workers: int | None = None,
    address: str | None = None,
    decision_timeout: float | None = DECISION_TIMEOUT,
    memory_limit: float | None = None,
) -> Engine:
    """Return an engine by name; both fly the same episodes.

    ``decision_timeout`` in seconds and ``memory_limit`` in GB limit a policy, see
    :mod:`indoor_explorers.evaluation.harness.experiment.limits`.

    Raises:
        InputError: the engine is unknown, an option does not apply to it, Ray is missing, or no cluster answers.
    """
    if name not in ENGINES:
        raise InputError(f"expected an engine, {' or '.join(ENGINES)}, got {name!r}")
    if name == "ray":
        return partial(_ray_engine(workers, address), decision_timeout=decision_timeout, memory_limit=memory_limit)
    if address is not None:
        raise InputError(f"expected --engine ray with --address {address}, got --engine local; leave one of them out")
    count = _local_count(workers)
    return partial(fly_jobs, workers=count, limits=limits_for(count, decision_timeout, memory_limit))


def kept_engine(workers: int | None = None) -> LocalWorkers:
    """Return a local engine for several runs in a row, whose worker processes are kept; use as a context manager.

    Workers are one for each core by default.
    """
    count = _local_count(workers)
    return LocalWorkers(count, limits_for(count, DECISION_TIMEOUT, None))


def _local_count(workers: int | None) -> int:
    return (os.cpu_count() or 1) if workers is None else workers


def _ray_engine(workers: int | None, address: str | None) -> Callable[..., Iterator[list[FlownEpisode]]]:
    if workers == 0:
        raise InputError("expected at least 1 of --workers with --engine ray, got 0; leave it out for all CPUs")
    try:
        from indoor_explorers.evaluation.harness.engines.ray_connection import check_address
        from indoor_explorers.evaluation.harness.engines.ray_engine import fly_jobs_on_ray
    except ModuleNotFoundError as error:
        if error.name != "ray":
            raise
        raise InputError("--engine ray needs Ray, which is not installed; install indoor-explorers[ray]") from error
    check_address(address)
    return partial(fly_jobs_on_ray, workers=workers, address=address)
