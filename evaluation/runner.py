"""Fly episodes: one policy, a batch of tasks in lock-step on one world."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from indoor_explorers.env import Action, InputError, Pilot, Policy, Scenario, View, World
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policy import is_action
from indoor_explorers.env.starts import draw_floorplan
from indoor_explorers.env.state import End
from indoor_explorers.evaluation.bounds import least_steps
from indoor_explorers.evaluation.experiment import Task
from indoor_explorers.evaluation.log import Flown, Log
from indoor_explorers.evaluation.metrics import LEVELS, team_metrics
from indoor_explorers.evaluation.record import Outcome, Record

#: Belief cells (episodes x agents x map) of one batch: bounds its memory to a few hundred megabytes.
BATCH_CELLS = 20_000_000


@dataclass
class _Flight:
    """One running episode of a batch."""

    place: int
    task: Task
    pilots: list[Pilot]
    bound: int
    """Steps that no team can do without on its way to 99 %."""
    latencies: list[float] = field(default_factory=list)
    """Seconds of each decision."""
    tallies: dict[str, float | None] = field(default_factory=dict)
    """Means over the UAVs of what their pilots tallied, prefixed by ``pilot_``."""
    failure: str = ""


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
    for place, (task, floorplan) in enumerate(tasks):
        world.begin(place, task.seed, floorplan=floorplan)
    flights = [_Flight(b, task, [], least_steps(world, b, LEVELS["t99"])) for b, (task, _) in enumerate(tasks)]
    batch = _Batch(policy, world, flights)
    batch.fly()
    return [_record(name, world, flight, batch.log.flown(flight.place)) for flight in flights]


class _Batch:
    """Fly a batch of episodes that have begun."""

    def __init__(self, policy: Policy, world: World, flights: Sequence[_Flight]) -> None:
        self.log = Log(world)
        self._policy = policy
        self._world = world
        self._flights = flights
        self._actions = np.empty(world.state.end.shape, np.int64)
        self._seconds = np.zeros(world.batch)

    def fly(self) -> None:
        """Fly every episode to its end."""
        for flight in self._flights:
            self._brief(flight)
        while self.log.running.any():
            self._actions[:] = Action.STAY
            self._seconds[:] = 0.0
            self._decide()
            self._world.step(self._actions)
            self.log.add(self._actions, self._seconds)
        for flight in self._flights:
            self._tally(flight)

    def _brief(self, flight: _Flight) -> None:
        try:
            for agent in range(self._world.scenario.team):
                briefing = self._world.briefing(flight.place, agent, privileged=self._policy.privileged)
                flight.pilots.append(self._policy.pilot(briefing))
        except Exception as error:
            self._fail(flight, error)

    def _tally(self, flight: _Flight) -> None:
        if flight.failure:
            return
        try:
            tallies = [pilot.tally() for pilot in flight.pilots]
            names = sorted({name for tally in tallies for name in tally})
            flight.tallies = {
                f"pilot_{name}": float(np.mean([tally[name] for tally in tallies if name in tally])) for name in names
            }
        except Exception as error:
            self._fail(flight, error)

    def _fail(self, flight: _Flight, error: Exception) -> None:
        flight.failure = f"{type(error).__name__}: {error}".replace("\n", " ")[:500]
        self.log.running[flight.place] = False

    def _decide(self) -> None:
        """Ask every flying UAV's pilot; fills the actions and the outboxes."""
        flying = self._world.flying & self.log.running[:, None]
        asked = [(self._flights[b], agent) for b, agent in np.argwhere(flying).tolist()]
        if type(self._policy).act is Policy.act:
            for flight, agent in asked:
                if self.log.running[flight.place]:
                    self._ask_one(flight, agent)
        elif asked:
            self._ask_together(asked)

    def _ask_one(self, flight: _Flight, agent: int) -> None:
        view = self._world.view(flight.place, agent)
        start = time.perf_counter()
        try:
            action = flight.pilots[agent].act(view)
        except Exception as error:
            return self._fail(flight, error)
        return self._enter(flight, agent, action, time.perf_counter() - start)

    def _ask_together(self, asked: Sequence[tuple[_Flight, int]]) -> None:
        pilots = [flight.pilots[agent] for flight, agent in asked]
        views: list[View] = [self._world.view(flight.place, agent) for flight, agent in asked]
        start = time.perf_counter()
        try:
            chosen = self._policy.act(pilots, views)
            if len(chosen) != len(asked):
                raise ValueError(f"act returned {len(chosen)} actions for {len(asked)} pilots")
        except Exception as error:
            for flight, _ in asked:
                self._fail(flight, error)
            return
        share = (time.perf_counter() - start) / len(asked)
        for (flight, agent), action in zip(asked, chosen, strict=True):
            self._enter(flight, agent, action, share)

    def _enter(self, flight: _Flight, agent: int, action: object, seconds: float) -> None:
        """Check one decision and put action and message where the world finds them."""
        flight.latencies.append(seconds)
        self._seconds[flight.place] += seconds
        try:
            if not is_action(action):
                raise InputError(f"expected an action from 0 to 4, got {action!r}")
            self._world.post(flight.place, agent, flight.pilots[agent].message)
            self._actions[flight.place, agent] = action
        except Exception as error:
            self._fail(flight, error)


def _outcome(world: World, flight: _Flight) -> tuple[Outcome, str]:
    ends = [End(int(end)) for end in world.state.end[flight.place]]
    if flight.failure:
        return Outcome.FAILED, flight.failure
    if End.GOAL in ends:
        return Outcome.COMPLETE, ""
    if End.BUDGET in ends:
        return Outcome.BUDGET, ""
    return Outcome.ENDED, ", ".join(f"UAV {n}: {end.name.lower().replace('_', ' ')}" for n, end in enumerate(ends))


def _record(name: str, world: World, flight: _Flight, flown: Flown) -> Record:
    state, b = world.state, flight.place
    outcome, reason = _outcome(world, flight)
    return Record(
        policy=name,
        task=flight.task,
        floorplan=world.floorplan(b),
        team=world.scenario.team,
        budget=int(state.budget[b]),
        reachable=int(state.total[b]),
        outcome=outcome,
        reason=reason,
        steps=len(flown.actions),
        metrics=_metrics(world, flight, flown),
        covered=flown.covered,
        cells=flown.cells,
        actions=flown.actions,
        seconds=flown.seconds,
        sent=flown.sent,
    )


def _metrics(world: World, flight: _Flight, flown: Flown) -> dict[str, float | None]:
    state, b = world.state, flight.place
    sensed, total, budget = state.sensed_count[b], int(state.total[b]), int(state.budget[b])
    covered = int(flown.covered[-1, 0])
    of_team = team_metrics(flown.covered, total, budget)
    late = of_team["t99"] if of_team["t99"] is not None else budget
    return {
        **of_team,
        "t99_to_bound": late / flight.bound if flight.bound else None,
        "path_length": float(state.path_length[b].sum()),
        "path_max": float(state.path_length[b].max()),
        "overlap": float((sensed.sum() - covered) / covered),
        "balance": float((sensed / total).std()),
        "collisions": float(state.collisions[b].sum()),
        "blocked": float(state.blocked[b].sum()),
        "messages_bytes": float(flown.sent[-1]),
        "age_of_information": flown.age,
        "latency_total_s": float(flown.seconds[-1]),
        "latency_p50_us": float(np.percentile(flight.latencies, 50) * 1e6) if flight.latencies else None,
        "latency_p99_us": float(np.percentile(flight.latencies, 99) * 1e6) if flight.latencies else None,
        **flight.tallies,
    }
