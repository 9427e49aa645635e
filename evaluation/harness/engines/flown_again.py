"""Flies some episodes of plug-ins again, each alone in a new process, where they count: in the comparison's scenarios.

A policy must choose the same again. In a team, one UAV is then shown another map, but flies and sends what it did: the
others must choose the same, as they know of it by its radio alone.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from hashlib import sha256
from itertools import chain, zip_longest
from math import ceil
from typing import NamedTuple

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.conformance.findings import CannotFly, Differs
from indoor_explorers.env.conformance.flying import CheckedFlight, Misled
from indoor_explorers.env.conformance.traces import Setup, Trace, compare
from indoor_explorers.env.errors import PolicyError
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.harness.engines.knowledge import Facts
from indoor_explorers.evaluation.harness.engines.loading import AT_ONCE, PolicyLoader
from indoor_explorers.evaluation.harness.engines.policy_handle import ProcessEnded
from indoor_explorers.evaluation.harness.engines.remote_policy import RemotePolicy
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, Job, PolicyChoice
from indoor_explorers.evaluation.harness.experiment.limits import Limits, limits_for
from indoor_explorers.evaluation.harness.results.store import Store
from indoor_explorers.evaluation.harness.results.written_rows import Flight

#: The share of a policy's episodes of a scenario that is flown again, and the least and the most of them.
SHARE, LEAST, MOST = 0.1, 3, 4
#: Seconds of deciding that all of a policy's episodes may take; what is not flown by then is not compared.
SECONDS = 20.0
#: Steps that are flown with a UAV that is shown another map.
STEPS = 200
FIX = "keep nothing in the policy, its class or its module, and in a batched act let no row look at another"


class _Due(NamedTuple):
    """What a policy has to fly again."""

    episodes: Sequence[tuple[Scenario, Record]]
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
        [(experiment.scenario(name), record) for record in store.records_at(_sample(some))]
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


def _judged(policy: RemotePolicy, episodes: Sequence[tuple[Scenario, Record]]) -> Facts:
    until = time.monotonic() + SECONDS
    for scenario, record in episodes:
        try:
            trace = _alone(policy, scenario, record)
            if scenario.team > 1:
                _apart(policy, scenario, record, trace)
        except Differs as error:
            where = f"in {scenario.name}, map {record.task.map_index}, seed {record.task.seed}"
            return {"failed_check": f"{error.found}, {where}; to fix it, {error.fix}"}
        if policy.ended or policy.unjudged or time.monotonic() > until:
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


def _apart(policy: RemotePolicy, scenario: Scenario, record: Record, trace: Trace) -> None:
    """Fly an episode with one UAV that is shown another map; demand that this changes nothing for the others."""
    misled = Misled(int(record.actions.sum()) % record.team, trace)
    again, _ = _flown(policy, scenario, record, min(STEPS, len(trace.steps)), misled)
    found = compare(again, trace, [agent for agent in range(record.team) if agent != misled.agent])
    if found.differs is not None:
        _alone(policy, scenario, record)  # it may remember the flights before
        agent, step = found.differs
        raise Differs(
            f"teammates apart: UAV {agent} chose differently at step {step} when only UAV {misled.agent} was shown "
            "another map, and flew and sent the same",
            "let pilots share nothing but messages, no list, dict or counter of the class, module or policy, and in a "
            "batched act let no row look at another",
        )


def _flown(
    policy: RemotePolicy, scenario: Scenario, record: Record, steps: int, misled: Misled | None = None
) -> tuple[Trace, CannotFly | None]:
    """Return what was flown, and the error that ended it."""
    setup = Setup(record.task.seed, record.floorplan)
    flight = CheckedFlight(policy, scenario, [setup], misled=misled, unseen=False)
    try:
        flight.fly(steps)
    except CannotFly as error:
        return flight.traces[0], error
    return flight.traces[0], None


def _same_actions(trace: Trace, record: Record) -> Iterator[bool]:
    for step, actions in zip(trace.steps, record.actions, strict=False):
        yield all(decision.action == actions[agent] for agent, decision in step.items())
