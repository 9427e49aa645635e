"""The driver of a comparison: fly what is missing, store it, and write the table, the figures and the report."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from indoor_explorers.env import InputError, Policy
from indoor_explorers.env.simulation.spawns import draw_floorplan, draw_spawns
from indoor_explorers.evaluation.engines.factory import make_engine
from indoor_explorers.evaluation.engines.workload import Workload
from indoor_explorers.evaluation.episodes.record import FlownEpisode
from indoor_explorers.evaluation.experiment.experiment import Experiment
from indoor_explorers.evaluation.experiment.provenance import run_facts
from indoor_explorers.evaluation.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.experiment.selection import chosen_baselines
from indoor_explorers.evaluation.experiment.sources import outside_files
from indoor_explorers.evaluation.results.store import Store

if TYPE_CHECKING:
    from indoor_explorers.evaluation.results.results import Results

#: Number of workers that jobs are planned for on a Ray cluster, whose size is not known beforehand.
CLUSTER_WORKERS = 32
#: The default options.
DEFAULTS = ComparisonRequest()


class Watcher(Protocol):
    """Receives the progress of a run."""

    def begin(self, total: int, missing: int) -> None:
        """Receive, before the first flight, the number of all episodes and of those that the store lacks."""

    def flown(self, records: Sequence[FlownEpisode], seconds_left: float | None) -> None:
        """Receive newly stored episodes and the estimated seconds until the last one; None without an estimate."""


def run(
    experiment: Experiment,
    out: Path,
    request: ComparisonRequest = DEFAULTS,
    *,
    watcher: Watcher | None = None,
    command: str = "",
) -> Results:
    """Fly the episodes that ``out`` lacks, then write the exports and the report.

    ``request`` says how episodes are flown: engine, workers and limits; see
    :func:`~indoor_explorers.evaluation.compare.compare`.
    """
    fly_missing(experiment, out, request, watcher=watcher, command=command)
    return write_outputs(out, request.ratio_to)


def fly_missing(
    experiment: Experiment,
    out: Path,
    request: ComparisonRequest = DEFAULTS,
    *,
    watcher: Watcher | None = None,
    command: str = "",
) -> None:
    """Fly the episodes that ``out/results.db`` lacks, and write nothing else; see :func:`run`."""
    how = request
    fly_jobs = make_engine(how.engine, how.workers, how.address, how.decision_timeout, how.memory_limit)
    about = {choice.name: policy_facts(choice.make(), choice.use) for choice in experiment.policies}
    for scenario in experiment.scenarios:  # refuses maps on which the team cannot start before anything is flown
        for index in range(scenario.map.count):
            draw_spawns(scenario, draw_floorplan(scenario, experiment.seed, index), experiment.seed)
    _make_folder(out)
    with Store(out / "results.db") as store:
        chosen_baselines([*store.policies(), *about], [], how.ratio_to)  # refuses unknown ones before anything is flown
        facts = run_facts(command, how.engine, how.workers)
        number = store.begin_run(experiment, about, facts, refly=how.refly, fresh=how.fresh)
        finished = store.finished(failed=not how.retry_failed)
        workload = Workload(experiment, finished, _worker_count(how))
        if watcher is not None:
            watcher.begin(len(experiment.policies) * len(experiment.tasks()), len(workload))
        for records in fly_jobs(workload) if workload else ():
            for record in records:
                store.add(record, number, replace_failed=how.retry_failed)
            workload.add(records)
            if watcher is not None:
                watcher.flown(records, workload.seconds_left())


def _worker_count(request: ComparisonRequest) -> int:
    """Return the number of workers that jobs are planned for."""
    if request.workers is not None:
        return request.workers
    return CLUSTER_WORKERS if request.engine == "ray" else os.cpu_count() or 1


def policy_facts(policy: Policy, use: str) -> dict[str, Any]:
    """Return the facts that results store about a policy: class, parameters, weights, sources, flags, and a hash."""
    parameters: dict[str, Any] = dataclasses.asdict(policy) if dataclasses.is_dataclass(policy) else {}
    facts = {
        "use": use,
        "class": f"{type(policy).__module__}:{type(policy).__qualname__}",
        "privileged": policy.privileged,
        "parameters": {name: repr(value) for name, value in parameters.items()},
        **policy.provenance(),
    }
    digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]
    facts |= {"sources": outside_files(policy, use)}
    return facts | {"hash": digest, "uses_generator": policy.uses_generator, "batched": policy.batched}


def _make_folder(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: the folder cannot be made: {error.strerror}; choose another --out") from error
    if not os.access(out, os.W_OK):
        raise InputError(f"{out}: expected a folder that can be written, got a read-only one; choose another --out")


def write_outputs(out: Path, ratio_to: Sequence[str] | None = None) -> Results:
    """Write the exports and the report from ``out/results.db``."""
    # imported here: they take seconds to import, and worker processes do not need them
    from indoor_explorers.evaluation.exports import write_exports
    from indoor_explorers.evaluation.report import write_report
    from indoor_explorers.evaluation.results.results import Results

    results = Results.load(out)
    write_exports(results, out, ratio_to=ratio_to)
    write_report(results, out / "report.html", ratio_to=ratio_to)
    return results
