"""Flies episodes: one policy, batches of tasks in lock-step on one world."""

from __future__ import annotations

import operator
import sysconfig
import traceback
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

from indoor_explorers.env import InputError, Policy, Scenario, World
from indoor_explorers.env.errors import PolicyError, one_line
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.policy import is_action
from indoor_explorers.env.simulation.rollout import Uav, rollout
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.episodes.record import Record
from indoor_explorers.evaluation.episodes.recorder import Log
from indoor_explorers.evaluation.episodes.running import RunningEpisode, simulated_record
from indoor_explorers.evaluation.episodes.shared_steps import Clock, DecisionTimeout, SharedStepBuffer
from indoor_explorers.evaluation.episodes.tallies import mean_tallies
from indoor_explorers.evaluation.episodes.thinking_time import thinking_time
from indoor_explorers.evaluation.experiment.experiment import Task

#: Belief cells (episodes x agents x map) of one batch: bounds its memory to a few hundred megabytes.
BATCH_CELLS = 20_000_000
#: Exceptions of a policy that fail its episode; Ctrl-C does not.
BREAKING = (Exception, SystemExit, DecisionTimeout)
#: Folders whose code asks policies, and that of Python itself.
_OURS = {Path(__file__).parents[2] / floor for floor in ("env", "evaluation")}
_STDLIB = Path(sysconfig.get_path("stdlib"))


class _BatchFailed(Exception):
    """A policy failed while it decided for several episodes at once."""


def fly(
    policy: Policy,
    name: str,
    scenario: Scenario,
    tasks: Sequence[Task],
    buffer: SharedStepBuffer | None = None,
    bounds: Mapping[Task, int] | None = None,
) -> Iterator[Record]:
    """Fly the tasks of one scenario and yield their records.

    Tasks on maps of one shape fly in lock-step, so that a batched policy gets one forward pass for all of
    them. A policy that raises fails only the episode it raised in. A ``buffer`` receives the time at which a decision
    began and, for a single task, every step. ``bounds`` are the lower bounds that are known already; others are
    computed. Times leave out what numba compiles or loads meanwhile.
    """
    drawn = {task: draw_floorplan(scenario, task.seed, task.map_index) for task in tasks}

    def shape(task: Task) -> tuple[int, int]:
        return drawn[task].shape

    for (height, width), group in groupby(sorted(tasks, key=shape), key=shape):
        batch = max(1, BATCH_CELLS // (height * width * scenario.team))
        alike = [(task, drawn[task], (bounds or {}).get(task)) for task in group]
        for start in range(0, len(alike), batch):
            some = alike[start : start + batch]
            try:
                yield from _fly_batch(policy, name, scenario, some, buffer)
            except _BatchFailed:  # episodes do not depend on their batch: flown alone, only the one at fault fails
                for one in some:
                    yield from _fly_batch(policy, name, scenario, [one], buffer)


def _fly_batch(
    policy: Policy,
    name: str,
    scenario: Scenario,
    tasks: Sequence[tuple[Task, Floorplan, int | None]],
    buffer: SharedStepBuffer | None,
) -> list[Record]:
    world = World(scenario, len(tasks))
    flights = [RunningEpisode(place, *task) for place, task in enumerate(tasks)]
    for flight in flights:
        flight.begin(world)
    batch = _Batch(policy, world, flights, buffer)
    batch.fly()
    return [
        simulated_record(flight, name, scenario, steps)
        if flight.failure
        else flight.record(name, world, batch.log, steps)
        for flight in flights
        for steps in [batch.log.steps(flight.place)]
    ]


class _Batch:
    """A batch of episodes that have begun."""

    def __init__(
        self,
        policy: Policy,
        world: World,
        flights: Sequence[RunningEpisode],
        buffer: SharedStepBuffer | None,
    ) -> None:
        self.log = Log(world)
        self._policy = policy
        self._world = world
        self._flights = flights
        self._clock = Clock() if buffer is None else buffer.clock
        self._buffer = buffer if world.batch == 1 else None
        self._seconds = np.zeros(world.batch)

    def fly(self) -> None:
        """Fly every episode to its end."""
        if self._buffer is not None:
            self._buffer.begin()
            self._buffer.add(self.log.latest[0])
        for flight in self._flights:
            self._brief(flight)
        for actions in rollout(self._world, self._ask):
            if not self.log.running.any():  # the last one failed at this step
                break
            self.log.add(actions, self._seconds)
            if self._buffer is not None:
                self._buffer.add(self.log.latest[0])
        for flight in self._flights:
            self._tally(flight)

    def _brief(self, flight: RunningEpisode) -> None:
        try:
            with self._clock:
                for agent in range(self._world.scenario.team):
                    briefing = self._world.briefing(flight.place, agent, privileged=self._policy.privileged)
                    flight.pilots.append(self._policy.pilot(briefing))
        except BREAKING as error:
            self._fail(flight, error)

    def _tally(self, flight: RunningEpisode) -> None:
        if flight.failure:
            return
        try:
            with self._clock:
                flight.tallies = mean_tallies([pilot.tally() for pilot in flight.pilots])
                flight.pilots.clear()  # deleted while the clock runs
        except BREAKING as error:
            self._fail(flight, error)

    def _fail(self, flight: RunningEpisode, error: BaseException) -> None:
        flight.failure = describe_error(error)
        self.log.running[flight.place] = False

    def _ask(self, flying: list[Uav]) -> Iterator[tuple[Uav, int]]:
        """Ask one UAV after the other, or all at once where the policy is batched; failed episodes are left out."""
        self._seconds[:] = 0.0
        asked = [uav for uav in flying if self.log.running[uav[0]]]
        for group in [asked] if self._policy.batched else [[uav] for uav in asked]:
            if group and self.log.running[group[0][0]]:
                yield from self._decide(group)

    def _decide(self, group: Sequence[Uav]) -> list[tuple[Uav, int]]:
        """Ask some UAVs in one call; return the actions of those whose decision is valid."""
        pilots = [self._flights[episode].pilots[agent] for episode, agent in group]
        views = [self._world.view(*uav) for uav in group]
        try:
            with self._clock:
                start = thinking_time()
                actions = list(self._policy.act(pilots, views))
                share = (thinking_time() - start) / len(group)
                if len(actions) != len(group):
                    raise ValueError(f"act returned {len(actions)} actions for {len(group)} pilots")
                decided = [(uav, self._accepted(uav, a, share)) for uav, a in zip(group, actions, strict=True)]
                return [(uav, action) for uav, action in decided if action is not None]
        except BREAKING as error:
            if len({episode for episode, _ in group}) > 1:
                raise _BatchFailed from error
            self._fail(self._flights[group[0][0]], error)
            return []

    def _accepted(self, uav: Uav, answer: object, seconds: float) -> int | None:
        """Check one decision, post its message and return its action; an invalid one fails its own episode."""
        episode, agent = uav
        flight = self._flights[episode]
        flight.latencies.append(seconds)
        self._seconds[episode] += seconds
        try:
            action = _action(answer)
            self._world.post(episode, agent, flight.pilots[agent].message)
        except (Exception, SystemExit) as error:
            self._fail(flight, error)
        return None if flight.failure else action


def _action(answer: object) -> int:
    """Return the action that an answer means, as an int that nobody can change any more."""
    if is_action(answer):
        action = operator.index(answer)  # of a subclass of int its true value, whatever its methods say
        if 0 <= action <= 4:
            return action
    raise InputError(f"expected an action from 0 to 4, got {answer!r}")


def describe_error(error: BaseException) -> str:
    """Return the type, message and place of a policy's exception as one short line that can be printed."""
    try:
        text = str(error)
    except BaseException as worse:
        text = f"its message raised {type(worse).__name__}"
    kind = "" if isinstance(error, DecisionTimeout) else f"{type(error).__name__}: "
    place = one_line(_place(error))
    return one_line(kind + text) + (place and f" ({place})")


def _place(error: BaseException) -> str:
    """Return where a policy raised, empty if it did not: the last line of its code, or of a library that it called."""
    if isinstance(error, DecisionTimeout):  # anywhere
        return ""
    cause = error.__cause__ if isinstance(error, (InputError, PolicyError)) else None
    trace = traceback.extract_tb((cause or error).__traceback__)
    frames = [frame for frame in trace if not _OURS.intersection(_folders(frame)) and "importlib" not in frame.filename]
    own = [frame for frame in frames if "site-packages" not in frame.filename and _STDLIB not in _folders(frame)]
    for frame in (own or frames)[-1:]:
        return f"{Path(frame.filename).name}:{frame.lineno} in {frame.name}"
    return ""


def _folders(frame: traceback.FrameSummary) -> set[Path]:
    return set(Path(frame.filename).parents)
