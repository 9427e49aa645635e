"""The driver of a comparison: fly what is missing, store it, and write the table, the figures and the report."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from indoor_explorers.env import InputError
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.env.simulation.spawns import draw_floorplan, draw_spawns
from indoor_explorers.evaluation.harness.engines.factory import Engine, make_engine
from indoor_explorers.evaluation.harness.engines.loading import PolicyLoader
from indoor_explorers.evaluation.harness.engines.plugin_checks import Facts, found_in_flights, with_failed_checks
from indoor_explorers.evaluation.harness.engines.workload import Workload
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, PolicyChoice, Task
from indoor_explorers.evaluation.harness.experiment.limits import limits_for
from indoor_explorers.evaluation.harness.experiment.policy_facts import with_chosen_on
from indoor_explorers.evaluation.harness.experiment.provenance import run_facts
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.experiment.selection import chosen_baselines
from indoor_explorers.evaluation.harness.results.policy_version import version_difference
from indoor_explorers.evaluation.harness.results.store import Store
from indoor_explorers.evaluation.harness.results.verification import (
    refuse_changed,
    refuse_changed_files,
    refuse_mismatches,
)

if TYPE_CHECKING:
    from indoor_explorers.evaluation.harness.results.results import Results

#: Number of workers that jobs are planned for on a Ray cluster, whose size is not known beforehand.
CLUSTER_WORKERS = 32
#: The default options.
DEFAULTS = ComparisonRequest()


class Watcher(Protocol):
    """Receives the progress of a run."""

    def begin(self, total: int, missing: int) -> None:
        """Receive, before the first flight, the number of episodes asked for and of those that the store lacks."""

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
    :func:`~indoor_explorers.evaluation.comparing.compare`.
    """
    fly_missing(experiment, out, request, watcher=watcher, command=command)
    models = {name for each in experiment.scenarios for name in (each.lidar.model, each.radio.model)}
    return write_outputs(out, request, models)


def fly_missing(
    experiment: Experiment,
    out: Path,
    request: ComparisonRequest = DEFAULTS,
    *,
    watcher: Watcher | None = None,
    command: str = "",
    only: Collection[Task] | None = None,
    engine: Engine | None = None,
) -> None:
    """Fly the episodes that ``out/results.db`` lacks, and write nothing else; see :func:`run`.

    Of the experiment's tasks ``only`` these, if given, are flown, and by ``engine`` instead of a new one.
    """
    how = request
    fly_jobs = engine or make_engine(how.engine, how.workers, how.address, how.decision_timeout, how.memory_limit)
    limits = None if how.workers == 0 else limits_for(1, how.decision_timeout, how.memory_limit)
    with PolicyLoader(limits) as loader:
        known = loader.facts(experiment.policies)
        about = {choice.name: with_chosen_on(known[choice.name], choice) for choice in experiment.policies}
        present = tuple(choice.by_present_names(about[choice.name]) for choice in experiment.policies)
        experiment = experiment.model_copy(update={"policies": present})
        _refuse_unstartable(experiment)
        _make_folder(out)
        with Store(out / "results.db", fresh=how.fresh) as store:
            about = _checked(experiment, about, store.policies(), loader, how)
            loader.close()  # its processes are no longer needed
            facts = run_facts(command, how.engine, how.workers)
            number = store.begin_run(experiment, _of_all_runs(about, store.policies()), facts, refly=how.refly)
            finished, tasks = store.finished(failed=not how.retry_failed), set(experiment.tasks())
            left_out = tasks.difference(tasks if only is None else only)
            finished |= {(each.name, task) for each in present for task in left_out}
            workload = Workload(experiment, finished, _worker_count(how), about=about)
            if watcher is not None:
                watcher.begin(len(present) * len(tasks - left_out), len(workload))
            for records in fly_jobs(workload) if workload else ():
                for record in records:
                    store.add(record, number, replace_failed=how.retry_failed)
                workload.add(records)
                if watcher is not None:
                    watcher.flown(records, workload.seconds_left())
            refuse_changed(store, number)
            refuse_changed_files(store, number, present)
            refuse_mismatches(store, experiment, number)
            if how.workers != 0:
                store.add_facts(found_in_flights(experiment, store, how.memory_limit))
                refuse_changed(store, number)


def _refuse_unstartable(experiment: Experiment) -> None:
    """Refuse maps on which the team cannot start, or that would be stored with two numbers of levels."""
    levels: dict[str, int] = {}
    for scenario in experiment.scenarios:
        for index in range(scenario.map.count):
            plan = draw_floorplan(scenario, experiment.seed, index)
            draw_spawns(scenario, plan, experiment.seed)
            if (count := levels.setdefault(plan.digest, plan.level_count)) != plan.level_count:
                raise InputError(
                    f"scenario {scenario.name!r}: expected map {plan.name!r} with {count} levels, as in another one, "
                    f"got {plan.level_count}; set map.least_levels of both"
                )


def _checked(
    experiment: Experiment,
    about: dict[str, Facts],
    stored: Mapping[str, Facts],
    loader: PolicyLoader,
    how: ComparisonRequest,
) -> dict[str, Facts]:
    """Add to the facts of policies which check they fail and whether they fly isolated; refuse unknown baselines."""
    chosen_baselines([*stored, *about], [], how.ratio_to)
    if how.workers != 0:
        about = with_failed_checks(experiment, about, stored, loader)
    return {c.name: about[c.name] | {"isolated": _flies_isolated(c, how)} for c in experiment.policies}


def _of_all_runs(about: Mapping[str, Facts], stored: Mapping[str, Facts]) -> dict[str, Facts]:
    """Return the facts to store, with what checks found in earlier runs.

    A policy flew isolated if it did so in all runs; older stores lack this fact.
    """
    merged = {}
    for name, facts in about.items():
        before = stored.get(name, facts)
        if version_difference(before, facts):
            before = facts
        found = {fact: before[fact] for fact in ("failed_check", "flown_again") if fact in before}
        merged[name] = found | facts | {"isolated": facts["isolated"] and before.get("isolated")}
    return merged


def _flies_isolated(choice: PolicyChoice, how: ComparisonRequest) -> bool:
    if how.workers == 0 or how.isolate == "none":
        return False
    return how.isolate == "all" or not is_own_policy(choice.use)


def _worker_count(request: ComparisonRequest) -> int:
    """Return the number of workers that jobs are planned for."""
    if request.workers is not None:
        return request.workers
    return CLUSTER_WORKERS if request.engine == "ray" else os.cpu_count() or 1


def _make_folder(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: the folder cannot be made: {error.strerror}; choose another --out") from error
    if not os.access(out, os.W_OK):
        raise InputError(f"{out}: expected a folder that can be written, got a read-only one; choose another --out")


def write_outputs(out: Path, request: ComparisonRequest = DEFAULTS, plugins: Iterable[str] = ()) -> Results:
    """Write the exports and the report from ``out/results.db``, with the baselines, metrics and panels asked for.

    ``plugins`` are the models from outside this package that may be imported for it.
    """
    # imported here: they take seconds to import, and worker processes do not need them
    from indoor_explorers.evaluation.exports import write_exports
    from indoor_explorers.evaluation.harness.results.custom_metrics import with_metrics
    from indoor_explorers.evaluation.harness.results.results import Results
    from indoor_explorers.evaluation.report import write_report

    results = with_metrics(Results.load(out, plugins), request.metrics)
    write_exports(results, out, ratio_to=request.ratio_to)
    write_report(results, out / "report.html", ratio_to=request.ratio_to, panels=request.panels)
    return results
