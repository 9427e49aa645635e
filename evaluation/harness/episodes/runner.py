"""Flies episodes: one policy, batches of tasks in lock-step on one world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby

import numpy as np

from indoor_explorers.env import Policy, Scenario, World
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.simulation.rollout import Uav, rollout
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.harness.episodes.pilots import BatchFailed, LocalPilots, Pilots
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.recorder import Log
from indoor_explorers.evaluation.harness.episodes.running import RunningEpisode, simulated_record
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock, SharedStepBuffer
from indoor_explorers.evaluation.harness.experiment.experiment import Task

#: Belief cells (episodes x agents x map) of one batch: bounds its memory to a few hundred megabytes.
BATCH_CELLS = 20_000_000


def fly(
    policy: Policy | Pilots,
    name: str,
    scenario: Scenario,
    tasks: Sequence[Task],
    buffer: SharedStepBuffer | None = None,
    bounds: Mapping[Task, int] | None = None,
    floorplans: Mapping[Task, Floorplan] | None = None,
) -> Iterator[Record]:
    """Fly the tasks of one scenario and yield their records.

    Tasks on maps of one shape fly in lock-step, so that a batched policy gets one forward pass for all of
    them. A policy that raises fails only the episode it raised in. Where the policy is in another process, give the
    pilots that stand for it there. A ``buffer`` receives the time at which a decision here began and, for a single
    task, every step. ``bounds`` are the lower bounds that are known already, ``floorplans`` the maps; others are
    computed, and drawn. Times leave out what numba compiles or loads meanwhile.
    """
    clock = Clock() if buffer is None else buffer.clock
    pilots = LocalPilots(policy, clock) if isinstance(policy, Policy) else policy
    known = floorplans or {}
    drawn = {task: known.get(task) or draw_floorplan(scenario, task.seed, task.map_index) for task in tasks}

    def shape(task: Task) -> tuple[int, int]:
        return drawn[task].shape

    for (height, width), group in groupby(sorted(tasks, key=shape), key=shape):
        batch = max(1, BATCH_CELLS // (height * width * scenario.team * maps_each(scenario)))
        alike = [(task, drawn[task], (bounds or {}).get(task)) for task in group]
        for start in range(0, len(alike), batch):
            some = alike[start : start + batch]
            try:
                yield from _fly_batch(pilots, name, scenario, some, buffer)
            except BatchFailed:  # episodes do not depend on their batch: flown alone, only the one at fault fails
                for one in some:
                    yield from _fly_batch(pilots, name, scenario, [one], buffer)


def maps_each(scenario: Scenario) -> int:
    """Return how many arrays of the map's size a UAV takes about: where paths may be corrected, one for each mate."""
    return scenario.team + 6 if scenario.uncertain else 1


def _fly_batch(
    pilots: Pilots,
    name: str,
    scenario: Scenario,
    tasks: Sequence[tuple[Task, Floorplan, int | None]],
    buffer: SharedStepBuffer | None,
) -> list[Record]:
    world = World(scenario, len(tasks))
    flights = [RunningEpisode(place, *task) for place, task in enumerate(tasks)]
    for flight in flights:
        flight.begin(world)
    log = _Batch(pilots, world, flights, buffer).fly()
    return [
        simulated_record(flight, name, scenario, steps) if flight.failure else flight.record(name, world, log, steps)
        for flight in flights
        for steps in [log.steps(flight.place)]
    ]


class _Batch:
    """A batch of episodes that have begun."""

    def __init__(
        self, pilots: Pilots, world: World, flights: Sequence[RunningEpisode], buffer: SharedStepBuffer | None
    ) -> None:
        self._log, self._pilots, self._world, self._flights = Log(world), pilots, world, flights
        self._buffer = buffer if world.batch == 1 else None
        self._seconds = np.zeros(world.batch)

    def fly(self) -> Log:
        """Fly every episode to its end; return the log of all steps."""
        if self._buffer is not None:
            self._buffer.begin()
            self._buffer.add(self._log.latest[0])
        self._brief()
        for actions in rollout(self._world, self._ask):
            if not self._log.running.any():  # the last one failed at this step
                break
            self._log.add(actions, self._seconds)
            if self._buffer is not None:
                self._buffer.add(self._log.latest[0])
        self._tally()
        return self._log

    def _brief(self) -> None:
        world, privileged = self._world, self._pilots.privileged
        briefings = {
            flight.place: [world.briefing(flight.place, n, privileged=privileged) for n in range(world.scenario.team)]
            for flight in self._flights
        }
        for place, failure in self._pilots.brief(briefings).items():
            self._fail(place, failure)

    def _tally(self) -> None:
        whole = [flight.place for flight in self._flights if not flight.failure]
        for place, tallies in self._pilots.tally(whole).items():
            if isinstance(tallies, str):
                self._fail(place, tallies)
            else:
                self._flights[place].tallies = tallies

    def _fail(self, place: int, failure: str) -> None:
        self._flights[place].failure = failure
        self._log.running[place] = False

    def _ask(self, flying: list[Uav]) -> Iterator[tuple[Uav, int]]:
        """Ask the UAVs of the episodes that have not failed; those that fail now stay where they are."""
        self._seconds[:] = 0.0
        views = {uav: self._world.view(*uav) for uav in flying if self._log.running[uav[0]]}
        going_on: set[int] = set()
        for uav, decision in self._pilots.decide(views).items():
            episode, agent = uav
            if decision.failure or not decision.done:
                going_on.add(episode)
            if decision.failure:
                self._fail(episode, decision.failure)
                continue
            self._flights[episode].latencies.append(decision.seconds)
            self._seconds[episode] += decision.seconds
            self._world.post(episode, agent, decision.message)
            yield uav, decision.action
        for episode in {episode for episode, _ in views} - going_on:
            self._flights[episode].declare_done(int(self._world.state.step[episode]))
