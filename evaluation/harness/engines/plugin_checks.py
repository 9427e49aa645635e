"""Checks plug-in policies for hidden knowledge: by conformance checks before they fly, and in some of their flights.

The checks are flown by this process; the policy decides in a process of its own, so that it cannot influence a verdict.
In a repeated flight, alone in a new process, a policy must choose the same actions again. In a team, one UAV is then
shown another map, but flies and sends what it did: the others must choose the same, as they know of it by radio alone.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from itertools import chain, zip_longest
from math import ceil
from typing import Any, NamedTuple

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.conformance import failed_check
from indoor_explorers.env.conformance.findings import CannotFly, Differs
from indoor_explorers.env.conformance.flying import CheckedFlight, Misled
from indoor_explorers.env.conformance.traces import Setup, Trace, compare
from indoor_explorers.env.errors import PolicyError
from indoor_explorers.env.policies.registry import is_own_policy
from indoor_explorers.evaluation.harness.engines.loading import AT_ONCE, PolicyLoader
from indoor_explorers.evaluation.harness.engines.policy_handle import ProcessEnded
from indoor_explorers.evaluation.harness.engines.remote_policy import RemotePolicy
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, Job, PolicyChoice
from indoor_explorers.evaluation.harness.experiment.limits import limits_for
from indoor_explorers.evaluation.harness.results.policy_version import version_difference
from indoor_explorers.evaluation.harness.results.store import Store
from indoor_explorers.evaluation.harness.results.written_rows import StoredFlight

#: Seconds of deciding after which a policy stays unchecked, and after which its flights are no longer repeated.
TIME_LIMIT, SECONDS = 10.0, 20.0
#: The share of a policy's episodes of a scenario that is flown again, and the least and the most of them.
SHARE, LEAST, MOST = 0.1, 3, 4
#: Steps that are flown with a UAV that is shown another map.
STEPS = 200
FIX = "keep nothing in the policy, its class or its module, and in a batched act let no row look at another"

Facts = dict[str, Any]


def with_failed_checks(
    experiment: Experiment, about: Mapping[str, Facts], stored: Mapping[str, Facts], loader: PolicyLoader
) -> dict[str, Facts]:
    """Return the facts of policies by name, those of plug-ins with the check for hidden knowledge that they fail.

    The fact ``failed_check`` is empty for a plug-in that passes, and missing for one that cannot be checked. A plug-in
    whose facts are ``stored`` is not checked again. The project's own policies and privileged ones are left out.
    """
    found = {
        name: {"failed_check": stored[name]["failed_check"]}
        for name, facts in about.items()
        if "failed_check" in stored.get(name, ()) and not version_difference(stored[name], facts)
    }
    unknown = [choice for choice in _ranked_plugins(experiment, about) if choice.name not in found]
    answers = loader.of_each(
        unknown,
        lambda choice: _failed_check(loader, Job(choice, experiment.scenarios[0], ()), about[choice.name]),
    )
    for choice, answer in zip(unknown, answers, strict=True):
        if answer is not None:
            found[choice.name] = {"failed_check": answer}
    return {name: facts | found.get(name, {}) for name, facts in about.items()}


def _ranked_plugins(experiment: Experiment, about: Mapping[str, Facts]) -> list[PolicyChoice]:
    """Return the policies from outside this package that are not privileged."""
    return [
        choice
        for choice in experiment.policies
        if not is_own_policy(choice.use) and not about[choice.name]["privileged"]
    ]


def _failed_check(loader: PolicyLoader, job: Job, facts: Facts) -> str | None:
    """Return which check a policy fails, empty for none; None if it takes too long or ends its process."""
    try:
        policy = _remote(loader, job, facts, TIME_LIMIT, None)
    except (ProcessEnded, InputError, PolicyError):
        return None
    found = failed_check(policy)
    return None if policy.ended or policy.unjudged else found


def _remote(loader: PolicyLoader, job: Job, facts: Facts, seconds: float, memory_limit: float | None) -> RemotePolicy:
    """Return the policy of a job in its own process, which has ``seconds`` for all its decisions."""
    return RemotePolicy(loader.process(job.policy, limits_for(AT_ONCE, seconds, memory_limit)), job, facts)


class _Repeats(NamedTuple):
    """The flights that a policy has to repeat."""

    episodes: Sequence[tuple[Scenario, Record]]
    flown: dict[str, int]
    """How many episodes of each scenario were stored when these were chosen."""


def found_in_flights(experiment: Experiment, store: Store, memory_limit: float | None) -> dict[str, Facts]:
    """Return facts to store about plug-ins by name: ``flown_again``, and ``failed_check`` where they failed.

    ``flown_again`` says how many episodes of each scenario were stored then: flights are not repeated again before
    there are more. Left out are the project's own policies, privileged ones, and those that failed a check before.
    """
    about = store.policies()
    repeats = {
        choice.name: found
        for choice in _ranked_plugins(experiment, about)
        if not about[choice.name].get("failed_check")
        and (found := _repeats(experiment, store, choice, about[choice.name].get("flown_again", {}))).episodes
    }

    def judged(choice: PolicyChoice) -> Facts:
        episodes, flown = repeats[choice.name]
        try:
            policy = _remote(loader, Job(choice, episodes[0][0], ()), about[choice.name], SECONDS, memory_limit)
            return _judged(policy, episodes) | ({} if policy.killed else {"flown_again": flown})
        except (ProcessEnded, InputError, PolicyError):
            return {}

    choices = [choice for choice in experiment.policies if choice.name in repeats]
    with PolicyLoader(limits_for(AT_ONCE, SECONDS, memory_limit)) as loader:
        return dict(zip(repeats, loader.of_each(choices, judged), strict=True))


def _repeats(experiment: Experiment, store: Store, choice: PolicyChoice, known: dict[str, int]) -> _Repeats:
    """Choose the flights to repeat: one of each scenario, then a second one of each, and so on."""
    flights = {scenario.name: store.flights(choice.name, scenario.name) for scenario in experiment.scenarios}
    flown = {name: len(some) for name, some in flights.items() if len(some) > known.get(name, 0)}
    chosen = [
        [(experiment.scenario(name), record) for record in store.records_at(_sample(flights[name]))] for name in flown
    ]
    rounds = chain.from_iterable(zip_longest(*chosen))
    return _Repeats([each for each in rounds if each is not None], known | flown)


def _sample(flights: Sequence[StoredFlight]) -> list[int]:
    """Return the rows of some episodes, in the reverse order of their flight.

    The choice depends on what was flown, so that no policy can foresee it. The first episode on each map is left out
    where there are others: a policy that remembers earlier episodes has nothing to remember there.
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
            trace = _repeat(policy, scenario, record)
            if scenario.team > 1:
                _check_teammates(policy, scenario, record, trace)
        except Differs as error:
            where = f"in {scenario.name}, map {record.task.map_index}, seed {record.task.seed}"
            return {"failed_check": f"{error.found}, {where}; to fix it, {error.fix}"}
        if policy.ended or policy.unjudged or time.monotonic() > until:
            break
    return {}


def _repeat(policy: RemotePolicy, scenario: Scenario, record: Record) -> Trace:
    """Fly an episode again; demand the recorded actions up to the time limit."""
    trace, error = _flown(policy, scenario, record, record.steps)
    step = next((n for n, same in enumerate(_same_actions(trace, record)) if not same), None)
    if step is None and error is not None and not policy.unjudged:
        raise Differs(f"episodes alone: an episode that was flown before failed when flown again ({error.found})", FIX)
    if step is not None:
        found = f"episodes alone: flown again in a new process, it chose differently from step {step} on"
        raise Differs(f"{found}: it remembers other episodes, or chooses at random", FIX)
    return trace


def _check_teammates(policy: RemotePolicy, scenario: Scenario, record: Record, trace: Trace) -> None:
    """Fly an episode with one UAV that is shown another map; demand that this changes nothing for the others."""
    misled = Misled(int(record.actions.sum()) % record.team, trace)
    again, _ = _flown(policy, scenario, record, min(STEPS, len(trace.steps)), misled)
    found = compare(again, trace, [agent for agent in range(record.team) if agent != misled.agent])
    if found.differs is not None:
        _repeat(policy, scenario, record)  # it may remember the flights before
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
    """Return the trace of a flight, and the error that ended it."""
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
