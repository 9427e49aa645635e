"""Fly episodes: one policy, a batch of tasks in lock-step on one world."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from indoor_explorers.env import Action, InputError, Policy, Scenario, View, World
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.policy import is_action
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.episodes.record import Record
from indoor_explorers.evaluation.episodes.recorder import Log
from indoor_explorers.evaluation.episodes.running import Flight, failed_record
from indoor_explorers.evaluation.episodes.shared_steps import Clock, DecisionTimeout, Spool, Steps
from indoor_explorers.evaluation.experiment.experiment import Task

#: Belief cells (episodes x agents x map) of one batch: bounds its memory to a few hundred megabytes.
BATCH_CELLS = 20_000_000
#: What ends an episode as failed when a policy raises it; Ctrl-C is nobody's fault.
BREAKING = (Exception, SystemExit, DecisionTimeout)


class _Undivided(Exception):
    """A policy failed at a decision for several episodes at once."""


def fly(
    policy: Policy,
    name: str,
    scenario: Scenario,
    tasks: Sequence[Task],
    spool: Spool | None = None,
    *,
    cold: bool = False,
) -> Iterator[Record]:
    """Fly the tasks of one scenario and yield their records.

    Tasks on maps of one shape fly in lock-step, so that a batched policy gets one forward pass for all of
    them. A policy that raises costs only the episode it raised in. A ``spool`` is told of decisions that are going
    on and, of a task alone, of every step. The first decisions of a policy that is ``cold`` in this process load and
    compile: they are left out of the latencies.
    """
    drawn = {task: draw_floorplan(scenario, task.seed, task.map_index) for task in tasks}

    def shape(task: Task) -> tuple[int, int]:
        return drawn[task].shape

    for (height, width), group in groupby(sorted(tasks, key=shape), key=shape):
        batch = max(1, BATCH_CELLS // (height * width * scenario.team))
        alike = [(task, drawn[task]) for task in group]
        for start in range(0, len(alike), batch):
            some = alike[start : start + batch]
            try:
                yield from _fly_batch(policy, name, scenario, some, spool, cold)
            except _Undivided:  # episodes do not depend on their batch: alone, each shows whether it is to blame
                for one in some:
                    yield from _fly_batch(policy, name, scenario, [one], spool, cold)
            cold = False


def _fly_batch(
    policy: Policy,
    name: str,
    scenario: Scenario,
    tasks: Sequence[tuple[Task, Floorplan]],
    spool: Spool | None,
    cold: bool,
) -> list[Record]:
    world = World(scenario, len(tasks))
    flights = [Flight.begin(world, place, *task) for place, task in enumerate(tasks)]
    batch = _Batch(policy, world, flights, spool, cold)
    batch.fly()
    return [
        failed_record(flight, name, scenario, floorplan, Steps(flown.actions, flown.seconds[1:], flown.sent[1:]))
        if flight.failure
        else flight.record(name, world, flown)
        for flight, (_, floorplan) in zip(flights, tasks, strict=True)
        for flown in [batch.log.flown(flight.place)]
    ]


class _Batch:
    """Fly a batch of episodes that have begun."""

    def __init__(
        self, policy: Policy, world: World, flights: Sequence[Flight], spool: Spool | None, cold: bool
    ) -> None:
        self.log = Log(world)
        self._policy = policy
        self._world = world
        self._flights = flights
        self._clock = Clock() if spool is None else spool.clock
        self._spool = spool if world.batch == 1 else None
        self._actions = np.empty(world.state.end.shape, np.int64)
        self._seconds = np.zeros(world.batch)
        self._cold = cold

    def fly(self) -> None:
        """Fly every episode to its end."""
        if self._spool is not None:
            self._spool.begin()
        for flight in self._flights:
            self._brief(flight)
        while self.log.running.any():
            self._actions[:] = Action.STAY
            self._seconds[:] = 0.0
            self._decide()
            if self.log.running.any():
                self._step()
        for flight in self._flights:
            self._tally(flight)

    def _step(self) -> None:
        self._cold = False
        self._world.step(self._actions)
        self.log.add(self._actions, self._seconds)
        if self._spool is not None:
            self._spool.add(self._actions[0], self._seconds[0], int(self._world.state.sent_bytes[0].sum()))

    def _brief(self, flight: Flight) -> None:
        try:
            with self._clock:
                for agent in range(self._world.scenario.team):
                    briefing = self._world.briefing(flight.place, agent, privileged=self._policy.privileged)
                    flight.pilots.append(self._policy.pilot(briefing))
        except BREAKING as error:
            self._fail(flight, error)

    def _tally(self, flight: Flight) -> None:
        if flight.failure:
            return
        try:
            with self._clock:
                tallies = [pilot.tally() for pilot in flight.pilots]
                names = sorted({name for tally in tallies for name in tally})
                flight.tallies = {
                    f"pilot_{name}": float(np.mean([tally[name] for tally in tallies if name in tally]))
                    for name in names
                }
        except BREAKING as error:
            self._fail(flight, error)

    def _fail(self, flight: Flight, error: BaseException) -> None:
        flight.failure = told(error)
        self.log.running[flight.place] = False

    def _decide(self) -> None:
        """Ask every flying UAV's pilot; fills the actions and the outboxes."""
        flying = self._world.flying & self.log.running[:, None]
        places, agents = np.nonzero(flying)
        asked = [(self._flights[b], agent) for b, agent in zip(places.tolist(), agents.tolist(), strict=True)]
        if type(self._policy).act is Policy.act:
            for flight, agent in asked:
                if self.log.running[flight.place]:
                    self._ask_one(flight, agent)
        elif asked:
            self._ask_together(asked)

    def _ask_one(self, flight: Flight, agent: int) -> None:
        view = self._world.view(flight.place, agent)
        try:
            with self._clock:
                start = time.perf_counter()
                action = flight.pilots[agent].act(view)
                self._enter(flight, agent, action, time.perf_counter() - start)
        except BREAKING as error:
            self._fail(flight, error)

    def _ask_together(self, asked: Sequence[tuple[Flight, int]]) -> None:
        pilots = [flight.pilots[agent] for flight, agent in asked]
        views: list[View] = [self._world.view(flight.place, agent) for flight, agent in asked]
        try:
            with self._clock:
                start = time.perf_counter()
                chosen = list(self._policy.act(pilots, views))
                share = (time.perf_counter() - start) / len(asked)
                if len(chosen) != len(asked):
                    raise ValueError(f"act returned {len(chosen)} actions for {len(asked)} pilots")
                self._enter_all(asked, chosen, share)
        except BREAKING as error:
            first = asked[0][0]
            if any(flight is not first for flight, _ in asked):
                raise _Undivided from error
            self._fail(first, error)

    def _enter_all(self, asked: Sequence[tuple[Flight, int]], chosen: Sequence[object], seconds: float) -> None:
        """Enter what was decided together; what is wrong with one decision fails its own episode."""
        for (flight, agent), action in zip(asked, chosen, strict=True):
            try:
                self._enter(flight, agent, action, seconds)
            except (Exception, SystemExit) as error:
                self._fail(flight, error)

    def _enter(self, flight: Flight, agent: int, action: object, seconds: float) -> None:
        """Check one decision and put action and message where the world finds them."""
        if not self._cold:
            flight.latencies.append(seconds)
        self._seconds[flight.place] += seconds
        if not is_action(action):
            raise InputError(f"expected an action from 0 to 4, got {action!r}")
        self._world.post(flight.place, agent, flight.pilots[agent].message)
        self._actions[flight.place, agent] = action


def told(error: BaseException) -> str:
    """Return what an exception of a policy says, in one short line that can be written anywhere."""
    try:
        text = str(error)
    except BREAKING as worse:
        text = f"its message raised {type(worse).__name__}"
    kind = "" if isinstance(error, DecisionTimeout) else f"{type(error).__name__}: "
    line = " ".join(f"{kind}{text}".split())[:500]
    return line.encode("utf-8", "replace").decode()
