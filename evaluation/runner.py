"""Fly episodes: one policy, a batch of tasks in lock-step on one world."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import InputError, Pilot, Policy, Scenario, View, World
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policy import is_action
from indoor_explorers.env.starts import draw_floorplan
from indoor_explorers.env.state import End
from indoor_explorers.evaluation.experiment import Task
from indoor_explorers.evaluation.metrics import curve_metrics
from indoor_explorers.evaluation.record import Outcome, Record

#: Belief cells (episodes x agents x map) of one batch: bounds its memory to a few hundred megabytes.
BATCH_CELLS = 20_000_000


@dataclass
class _Flight:
    """One running episode of a batch."""

    place: int
    task: Task
    pilots: list[Pilot]
    covered: list[NDArray[np.int64]] = field(default_factory=list)
    cells: list[NDArray[np.int64]] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    failure: str = ""
    running: bool = True


def fly(policy: Policy, name: str, scenario: Scenario, tasks: Sequence[Task]) -> Iterator[Record]:
    """Fly the tasks of one scenario and yield their records.

    Tasks on maps of one shape fly in lock-step, so that a batched policy gets one forward pass for all of
    them. A policy that raises costs only the episode it raised in.
    """
    drawn = {task: draw_floorplan(scenario, task.seed, task.map_index) for task in tasks}

    def shape(task: Task) -> tuple[int, int]:
        return drawn[task].shape

    for (height, width), group in groupby(sorted(tasks, key=shape), key=shape):
        batch = max(1, BATCH_CELLS // (height * width * scenario.team))
        alike = list(group)
        for start in range(0, len(alike), batch):
            some = alike[start : start + batch]
            yield from _fly_batch(policy, name, scenario, [(task, drawn[task]) for task in some])


def _fly_batch(policy: Policy, name: str, scenario: Scenario, tasks: Sequence[tuple[Task, Floorplan]]) -> list[Record]:
    world = World(scenario, len(tasks))
    flights = []
    for place, (task, floorplan) in enumerate(tasks):
        world.begin(place, task.seed, floorplan=floorplan)
        flights.append(_Flight(place, task, []))
        _brief(policy, world, flights[-1])
        _log(world, flights[-1])
    actions = np.empty((len(tasks), scenario.team), np.int64)
    while any(flight.running for flight in flights):
        actions[:] = 4
        _decide(policy, world, flights, actions)
        world.step(actions)
        for flight in flights:
            if flight.running:
                _log(world, flight)
    return [_record(name, world, flight) for flight in flights]


def _brief(policy: Policy, world: World, flight: _Flight) -> None:
    try:
        for agent in range(world.scenario.team):
            briefing = world.briefing(flight.place, agent, privileged=policy.privileged)
            flight.pilots.append(policy.pilot(briefing))
    except Exception as error:
        _fail(flight, error)


def _fail(flight: _Flight, error: Exception) -> None:
    flight.failure = f"{type(error).__name__}: {error}".replace("\n", " ")[:500]
    flight.running = False


def _log(world: World, flight: _Flight) -> None:
    state, b = world.state, flight.place
    flight.covered.append(np.concatenate((state.team_covered[b : b + 1], state.covered[b])))
    flight.cells.append(state.cell[b].copy())
    flight.running = flight.running and bool((state.end[b] == End.FLYING).any())


def _decide(policy: Policy, world: World, flights: Sequence[_Flight], actions: NDArray[np.int64]) -> None:
    """Ask every flying UAV's pilot; fills ``actions`` (B, N) and the outboxes."""
    flying = world.flying
    asked = [(f, n) for f in flights if f.running for n in np.flatnonzero(flying[f.place]).tolist()]
    if type(policy).act is Policy.act:
        for flight, agent in asked:
            if flight.running:
                _ask_one(world, flight, agent, actions)
    else:
        _ask_batch(policy, world, asked, actions)


def _ask_one(world: World, flight: _Flight, agent: int, actions: NDArray[np.int64]) -> None:
    view = world.view(flight.place, agent)
    start = time.perf_counter()
    try:
        action = flight.pilots[agent].act(view)
    except Exception as error:
        return _fail(flight, error)
    flight.seconds.append(time.perf_counter() - start)
    return _enter(world, flight, agent, action, actions)


def _ask_batch(policy: Policy, world: World, asked: Sequence[tuple[_Flight, int]], actions: NDArray[np.int64]) -> None:
    pilots = [flight.pilots[agent] for flight, agent in asked]
    views: list[View] = [world.view(flight.place, agent) for flight, agent in asked]
    start = time.perf_counter()
    try:
        chosen = policy.act(pilots, views)
        if len(chosen) != len(asked):
            raise ValueError(f"act returned {len(chosen)} actions for {len(asked)} pilots")
    except Exception as error:
        for flight, _ in asked:
            _fail(flight, error)
        return
    share = (time.perf_counter() - start) / len(asked)
    for (flight, agent), action in zip(asked, chosen, strict=True):
        flight.seconds.append(share)
        _enter(world, flight, agent, action, actions)


def _enter(world: World, flight: _Flight, agent: int, action: object, actions: NDArray[np.int64]) -> None:
    """Check one decision and put action and message where the world finds them."""
    try:
        if not is_action(action):
            raise InputError(f"expected an action from 0 to 4, got {action!r}")
        world.post(flight.place, agent, flight.pilots[agent].message)
        actions[flight.place, agent] = action
    except Exception as error:
        _fail(flight, error)


def _outcome(world: World, flight: _Flight) -> tuple[Outcome, str]:
    ends = [End(int(end)) for end in world.state.end[flight.place]]
    if flight.failure:
        return Outcome.FAILED, flight.failure
    if End.GOAL in ends:
        return Outcome.COMPLETE, ""
    if End.BUDGET in ends:
        return Outcome.BUDGET, ""
    return Outcome.ENDED, ", ".join(f"UAV {n}: {end.name.lower().replace('_', ' ')}" for n, end in enumerate(ends))


def _record(name: str, world: World, flight: _Flight) -> Record:
    state, b = world.state, flight.place
    covered = np.array(flight.covered, np.int32)
    floorplan = world.floorplan(b)
    outcome, reason = _outcome(world, flight)
    sensed, total = state.sensed_count[b], int(state.total[b])
    curve = covered[:, 0] / total
    metrics: dict[str, float | None] = {
        **curve_metrics(curve, int(state.budget[b])),
        "path_length": float(state.path_length[b].sum()),
        "path_max": float(state.path_length[b].max()),
        "overlap": float((sensed.sum() - state.team_covered[b]) / state.team_covered[b]),
        "balance": float((sensed / total).std()),
        "collisions": float(state.collisions[b].sum()),
        "blocked": float(state.blocked[b].sum()),
        "messages_bytes": float(state.sent_bytes[b].sum()),
        "latency_p50_us": float(np.percentile(flight.seconds, 50) * 1e6) if flight.seconds else None,
        "latency_p99_us": float(np.percentile(flight.seconds, 99) * 1e6) if flight.seconds else None,
        **_tallied(flight),
    }
    return Record(
        policy=name,
        task=flight.task,
        floorplan=floorplan,
        team=world.scenario.team,
        budget=int(state.budget[b]),
        reachable=total,
        outcome=outcome,
        reason=reason,
        steps=len(covered) - 1,
        metrics=metrics,
        covered=covered,
        cells=np.array(flight.cells, np.int16),
    )


def _tallied(flight: _Flight) -> dict[str, float | None]:
    """Return the mean over the UAVs of what their pilots tallied, prefixed by ``pilot_``."""
    tallies = [pilot.tally() for pilot in flight.pilots] if not flight.failure else []
    names = sorted({name for tally in tallies for name in tally})
    return {f"pilot_{name}": float(np.mean([tally[name] for tally in tallies if name in tally])) for name in names}
