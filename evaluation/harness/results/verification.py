"""Refuses a store before its report is written if its rows are not what was flown.

Policies could change the file, and what they are made from may change while they fly.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.harness.episodes.mismatch import mismatch
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, PolicyChoice, episode_name
from indoor_explorers.evaluation.harness.experiment.sources import changed_files, outside_files
from indoor_explorers.evaluation.harness.results.store import Store, some_of

#: Seconds of simulating episodes of earlier runs again; the rest is not simulated.
SECONDS = 5.0
#: Episodes that are read at once.
AT_ONCE = 50
#: What to do about the policy that may have changed something.
DISTRUST = "leave out the policies that you do not trust"


def refuse_changed(store: Store, run: int) -> None:
    """Refuse rows that another program changed, added or removed during a run; episodes are set aside.

    Raises:
        RunError: there are such rows.

    """
    changed = store.changed(run)
    if changed:
        mendable = all(table == "episode" for table, _ in changed)
        store.set_aside([rowid for table, rowid in changed if table == "episode"])
        again = "the same command flies the episodes again" if mendable else "start again with --fresh"
        raise RunError(
            f"{store.path}: another program, perhaps a policy, changed it while this command ran: "
            f"{some_of(list(changed.values()))}; {DISTRUST}, then {again}"
        )


def refuse_changed_files(store: Store, run: int, choices: Iterable[PolicyChoice]) -> None:
    """Refuse a run's episodes of this package's policies whose files changed meanwhile; they are set aside.

    ``choices`` are the policies of the run. A training that goes on changes its weights, and workers read them again.

    Raises:
        RunError: there are such files.

    """
    rows, facts = store.rows_of([run]), store.policies()
    faults: dict[str, str] = {}
    for choice in choices if rows else ():
        if is_own_policy(choice.use):
            files = changed_files(facts[choice.name].get("sources"), outside_files(choice.make(), choice.use))
            if files:
                faults[choice.name] = f"{choice.name!r}: {', '.join(files)}"
    if faults:
        store.set_aside([row for row, each in zip(rows, store.records_at(rows), strict=True) if each.policy in faults])
        raise RunError(
            "expected the files that policies fly with to stay as they are, got changes while they flew, of "
            f"{some_of(list(faults.values()))}; these episodes are set aside: wait for the end of the training or fly "
            "a copy of its weights, with --fresh or another --out"
        )


def refuse_mismatches(store: Store, experiment: Experiment, run: int) -> None:
    """Refuse episodes of earlier runs that are not what their actions give; they are set aside.

    Where plug-ins were flown, episodes are simulated in a random order for some seconds. Runs of other versions of the
    software are left out, as their world may be another one.

    Raises:
        RunError: there are such episodes.

    """
    if all(_is_own(facts) for facts in store.policies().values()):
        return
    rows = np.random.default_rng().permutation(store.rows_of(_alike(store.all_runs(), run))).tolist()
    faults: dict[int, str] = {}
    until = time.process_time() + SECONDS
    while rows and time.process_time() < until:
        some, rows = rows[:AT_ONCE], rows[AT_ONCE:]
        for rowid, record in zip(some, store.records_at(some), strict=True):
            if fault := mismatch(record, experiment.scenario(record.task.scenario)):
                faults[rowid] = f"{episode_name(record.policy, record.task)}: {fault}"
    if faults:
        store.set_aside(faults)
        raise RunError(
            f"{store.path}: episodes of an earlier run are not what their actions give: "
            f"{some_of(list(faults.values()))}; {DISTRUST}, then the same command flies the episodes again"
        )


def _is_own(facts: Mapping[str, Any]) -> bool:
    try:
        return is_own_policy(facts["use"])
    except InputError:  # it is not installed any more
        return False


def _alike(runs: Mapping[int, Mapping[str, Any]], run: int) -> list[int]:
    """Return the other runs of the same versions of the software."""
    names = {name for facts in runs.values() for name in facts if name == "commit" or name.endswith(" version")}
    now = runs[run]
    return [
        number
        for number, facts in runs.items()
        if number != run and all(facts.get(name) == now.get(name) for name in names)
    ]
