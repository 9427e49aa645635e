"""Flies some episodes of plug-ins again, each alone in a new process, where they count: in the comparison's scenarios.

A policy must choose the same again. In a team, a UAV then acts differently while others are out of contact with it:
they must choose the same until they see or hear of this.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from hashlib import sha256
from itertools import chain, zip_longest
from math import ceil
from typing import NamedTuple

import numpy as np

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.conformance.findings import CannotFly, Differs
from indoor_explorers.env.conformance.flying import Changed, CheckedFlight
from indoor_explorers.env.conformance.information_leaks import demand_unlinked
from indoor_explorers.env.conformance.traces import Setup, Trace
from indoor_explorers.env.errors import PolicyError
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.engines.knowledge import Facts
from indoor_explorers.evaluation.engines.loading import AT_ONCE, PolicyLoader
from indoor_explorers.evaluation.engines.policy_handle import ProcessEnded
from indoor_explorers.evaluation.engines.remote_policy import RemotePolicy
from indoor_explorers.evaluation.episodes.record import Record
from indoor_explorers.evaluation.episodes.resimulate import resimulate
from indoor_explorers.evaluation.experiment.experiment import Experiment, Job, PolicyChoice
from indoor_explorers.evaluation.experiment.limits import Limits, limits_for
from indoor_explorers.evaluation.results.store import Store
from indoor_explorers.evaluation.results.written_rows import Flight

#: The share of a policy's episodes of a scenario that is flown again, and the least and the most of them.
SHARE, LEAST, MOST = 0.1, 2, 4
#: Seconds of deciding that all of a policy's episodes may take; what is not flown by then is not compared.
SECONDS = 20.0
#: Steps that are flown after a UAV began to act differently.
STEPS = 200
FIX = "keep nothing in the policy, its class or its module, and in a batched act let no row look at another"


class _Due(NamedTuple):
    """What a policy has to fly again."""

    episodes: Sequence[tuple[Scenario, Record, bool]]
    """Each with whether it is the first of its scenario, on which a teammate is changed."""
    flown: dict[str, int]
    """How many episodes of each scenario were flown when these were chosen."""


def found_in_flights(experiment: Experiment, store: Store, memory_limit: float | None) -> dict[str, Facts]:
    """Return what is to be noted about plug-ins by name: ``flown_again``, and ``failed_check`` where they failed.

    ``flown_again`` says how many episodes of each scenario were stored then: it is not done again before there are
    more. Left out are the project's own policies, privileged ones, and those that failed a check before.
    """
    about = store.policies()
    due = {
        choice.name: found
        for choice in experiment.policies
        if not is_own_policy(choice.use)
        and not (about[choice.name]["privileged"] or about[choice.name].get("failed_check"))
        and (found := _due(experiment, store, choice, about[choice.name].get("flown_again", {}))).episodes
    }
    choices = [choice for choice in experiment.policies if choice.name in due]
    limits = Limits(SECONDS, limits_for(AT_ONCE, None, memory_limit).memory)

    def judged(choice: PolicyChoice) -> Facts:
        episodes, flown = due[choice.name]
        job = Job(choice, episodes[0][0], ())
        try:
            policy = RemotePolicy.of(loader.process(choice, limits), job, about[choice.name], SECONDS)
            return _judged(policy, episodes) | ({} if policy.killed else {"flown_again": flown})
        except (ProcessEnded, InputError, PolicyError):
            return {}

    with PolicyLoader(limits) as loader:
        return dict(zip(due, loader.of_each(choices, judged), strict=True))


def _due(experiment: Experiment, store: Store, choice: PolicyChoice, known: dict[str, int]) -> _Due:
    """Choose what a policy flies again: one episode of each scenario, then a second one of each, and so on."""
    flights = {scenario.name: store.flights(choice.name, scenario.name) for scenario in experiment.scenarios}
    flown = {name: len(some) for name, some in flights.items() if len(some) > known.get(name, 0)}
    chosen = [
        [(experiment.scenario(name), record, n == 0) for n, record in enumerate(store.records_at(_sample(some)))]
        for name, some in flights.items()
        if name in flown
    ]
    rounds = chain.from_iterable(zip_longest(*chosen))
    return _Due([each for each in rounds if each is not None], known | flown)


def _sample(flights: Sequence[Flight]) -> list[int]:
    """Return the rows of some episodes, in the reverse order of their flight.

    Which they are depends on what was flown, so no policy can tell beforehand. The first one on each map is left out
    where there are others: a policy that remembers what it flew has nothing to remember there.
    """
    first = {flight.map_index: flight.rowid for flight in reversed(flights)}.values()
    later = [flight for flight in flights if flight.rowid not in first] or flights
    ranked = sorted(later, key=lambda flight: sha256(flight.actions).digest())
    count = min(MOST, max(LEAST, ceil(SHARE * len(flights))))
    return sorted((flight.rowid for flight in ranked[:count]), reverse=True)


def _judged(policy: RemotePolicy, episodes: Sequence[tuple[Scenario, Record, bool]]) -> Facts:
    until = time.monotonic() + SECONDS
    for scenario, record, changing in episodes:
        try:
            trace = _alone(policy, scenario, record)
            if changing and scenario.team > 1:
                _changed(policy, scenario, record, trace)
        except Differs as error:
            where = f"in {scenario.name}, map {record.task.map_index}, seed {record.task.seed}"
            return {"failed_check": f"{error.found}, {where}; to fix it, {error.fix}"}
        if policy.unjudged or time.monotonic() > until:
            break
    return {}


def _alone(policy: RemotePolicy, scenario: Scenario, record: Record) -> Trace:
    """Fly an episode again; demand the recorded actions, as far as it comes in time."""
    trace, error = _flown(policy, scenario, record, record.steps)
    step = next((n for n, same in enumerate(_same_actions(trace, record)) if not same), None)
    if step is None and error is not None and not policy.unjudged:
        raise Differs(f"episodes alone: an episode that was flown before failed when flown again ({error.found})", FIX)
    if step is not None:
        found = f"episodes alone: flown again in a new process, it chose differently from step {step} on"
        raise Differs(f"{found}: it remembers other episodes, or chooses at random", FIX)
    return trace


def _changed(policy: RemotePolicy, scenario: Scenario, record: Record, trace: Trace) -> None:
    """Fly an episode with one UAV that acts differently; demand that others choose the same before they know of it."""
    changed = longest_silence(record, scenario)
    if changed is not None:
        again, _ = _flown(policy, scenario, record, changed.since + STEPS, changed)
        try:
            demand_unlinked(scenario, again, trace, changed)
        except Differs as error:
            _alone(policy, scenario, record)  # it may remember the flights before
            raise Differs(f"unlinked teammates: {error.found}", error.fix) from error


def _flown(
    policy: RemotePolicy, scenario: Scenario, record: Record, steps: int, changed: Changed | None = None
) -> tuple[Trace, CannotFly | None]:
    """Return what was flown, and the error that ended it."""
    setup = Setup(record.task.seed, record.floorplan)
    flight = CheckedFlight(policy, scenario, [setup], changed=changed, unseen=False)
    try:
        flight.fly(steps)
    except CannotFly as error:
        return flight.traces[0], error
    return flight.traces[0], None


def _same_actions(trace: Trace, record: Record) -> Iterator[bool]:
    for step, actions in zip(trace.steps, record.actions, strict=False):
        yield all(decision.action == actions[agent] for agent, decision in step.items())


def longest_silence(record: Record, scenario: Scenario) -> Changed | None:
    """Return the UAV of which the others hear nothing for the longest time, and the step at which that begins.

    The time counts for each of the others, up to :data:`STEPS`; None where all hear of all at every step.
    """
    received = np.stack([world.state.last_received_step[0].copy() for world in resimulate(record, scenario)])
    steps, team = np.arange(len(received)), record.team
    heard = received == steps[:, None, None]
    following = np.full((len(received) + 1, team, team), len(received))
    for step in reversed(steps):
        following[step] = np.where(heard[step], step, following[step + 1])
    silent = np.clip(following[1:] - steps[:, None, None] - 1, 0, STEPS)
    silent[:, np.arange(team), np.arange(team)] = 0
    total = silent.sum(axis=1)
    since, agent = divmod(int(total.argmax()), team)
    return Changed(agent, wanders=True, since=since) if total.max() else None
