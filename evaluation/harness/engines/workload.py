"""The work of a run: missing episodes in jobs, the longest first, and an estimate of the time left."""

from __future__ import annotations

import math
import time
from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from threading import RLock
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

from indoor_explorers.env import Scenario
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, Job, PolicyChoice, Task

#: Limits of a job in episodes and in cells x steps x UAVs; a worker loses at most one job when a run is killed.
#: Jobs of fifty episodes cost a sixth less an episode than jobs of ten.
JOB_EPISODES, JOB_WORK = 50, 40_000_000
#: A job is at most this share of a worker's remaining work, so that all workers end at about the same time, but at
#: least this many seconds.
SHARE, LEAST = 0.1, 0.5
#: Seconds besides decisions: of an episode, and of each step of a UAV.
EPISODE, STEP = 0.01, 15e-6


class Jobs(Protocol):
    """The jobs of a run: a list, or a :class:`Workload`, whose next job is chosen when it is asked for."""

    def __len__(self) -> int:
        """Return how many there are, or an upper bound."""

    def __iter__(self) -> Iterator[Job]:
        """Yield them in the order in which they are to be flown."""


class _Size(NamedTuple):
    """The estimated cost of an episode of a scenario before any was flown."""

    work: float
    """Roughly proportional to the time of its decisions; without a unit."""
    most: int
    """The most episodes of a job."""


class Workload:
    """The missing episodes of an experiment: iterate for the jobs, and add the records as they come.

    The first job of every policy in every scenario is one episode, which measures what the others will cost. After
    that, the policy and scenario with the longest episodes come first. Jobs can be taken, and records added, by
    several threads.
    """

    def __init__(
        self,
        experiment: Experiment,
        finished: set[tuple[str, Task]],
        workers: int,
        clock: Callable[[], float] = time.monotonic,
        about: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
    ) -> None:
        """Leave out ``finished`` episodes; the size of jobs depends on the number of ``workers``.

        ``about`` are the facts of policies by name, which say whether one is privileged and flies isolated.
        """
        self._about = about
        self._lock = RLock()
        self._workers, self._clock = max(1, workers), clock
        self._sizes = {scenario.name: _size(scenario, experiment.seed) for scenario in experiment.scenarios}
        self._waiting: dict[tuple[str, str], tuple[PolicyChoice, Scenario, list[Task]]] = {}
        tasks = experiment.tasks()
        for scenario in experiment.scenarios:
            for choice in experiment.policies:
                missing = [t for t in tasks if t.scenario == scenario.name and (choice.name, t) not in finished]
                if missing:
                    self._waiting[choice.name, scenario.name] = choice, scenario, missing
        self._pairs, self._total = tuple(self._waiting), len(self)
        self._tried: set[tuple[str, str]] = set()
        self._flying: Counter[tuple[str, str]] = Counter()
        self._flown: Counter[tuple[str, str]] = Counter()
        self._seconds: defaultdict[tuple[str, str], float] = defaultdict(float)
        self._bounds: dict[Task, int] = {}
        self._done = [(clock(), 0.0)]
        """(time, seconds of work done) whenever records came; of running jobs half counts as done."""

    def __len__(self) -> int:
        """Return how many episodes are in no job yet."""
        return sum(len(tasks) for _, _, tasks in self._waiting.values())

    def __iter__(self) -> Iterator[Job]:
        """Yield the jobs; which comes next depends on the records added so far."""
        while (job := self.take()) is not None:
            yield job

    def take(self, loaded: Collection[PolicyChoice] = ()) -> Job | None:
        """Return the next job, if possible of a policy that a worker has ``loaded``; None when all were taken."""
        with self._lock:
            if not self._waiting:
                return None
            untried = [pair for pair in self._waiting if pair not in self._tried]
            rest = untried or list(self._waiting)
            rest = [pair for pair in rest if self._waiting[pair][0] in loaded] or rest
            pair = rest[0] if untried else max(rest, key=self.episode_seconds)
            self._tried.add(pair)
            return self._job(pair, 1 if untried else self._episodes(pair))

    def add(self, records: Sequence[FlownEpisode]) -> None:
        """Add stored episodes: what they cost, and the lower bounds of their tasks."""
        with self._lock:
            for record in records:
                pair = record.policy, record.task.scenario
                self._bounds[record.task] = record.bound
                self._flying[pair] -= 1
                self._flown[pair] += 1
                self._seconds[pair] += float(record.seconds[-1]) + EPISODE + STEP * record.steps * record.team
            self._done.append((self._clock(), sum(self._seconds.values()) + self._flying_seconds() / 2))

    def seconds_left(self) -> float | None:
        """Estimate the seconds until all episodes are flown; None before enough is known.

        Enough is one episode of each policy in each scenario, or a fifth of all. The speed is that of the latest half
        of the run, so that compiling at its start does not count.
        """
        with self._lock:
            now, done = self._clock(), self._done
            known = all(self._flown[pair] for pair in self._pairs) or 5 * sum(self._flown.values()) >= self._total
            if done[-1][1] == 0.0 or not known:
                return None
            begun = done[0][0]
            since, before = done[max(0, bisect_left(done, (begun + (now - begun) / 2, 0.0)) - 1)]
            latest, spent = done[-1]
            pace = (latest - since) / (spent - before) if spent > before else (now - begun) / spent
            return (self._waiting_seconds() + self._flying_seconds() / 2) * pace

    def episode_seconds(self, pair: tuple[str, str]) -> float:
        """Estimate the seconds of an episode of a (policy, scenario) from those already flown.

        Before any was flown, from the policy's other scenarios, and without these from the other policies.
        """
        if self._flown[pair]:
            return self._seconds[pair] / self._flown[pair]
        own = [other for other in self._flown if other[0] == pair[0]]
        known = own or list(self._flown)
        work = sum(self._flown[other] * self._sizes[other[1]].work for other in known)
        rate = sum(self._seconds[other] for other in known) / work if work else 1.0
        return rate * self._sizes[pair[1]].work

    def _flying_seconds(self) -> float:
        return sum(count * self.episode_seconds(pair) for pair, count in self._flying.items())

    def _waiting_seconds(self) -> float:
        return sum(len(tasks) * self.episode_seconds(pair) for pair, (_, _, tasks) in self._waiting.items())

    def _episodes(self, pair: tuple[str, str]) -> int:
        """Return how many episodes the next job of a (policy, scenario) has."""
        share = max(LEAST, SHARE * self._waiting_seconds() / self._workers)
        return max(1, min(int(share / self.episode_seconds(pair)), self._sizes[pair[1]].most))

    def _job(self, pair: tuple[str, str], episodes: int) -> Job:
        choice, scenario, tasks = self._waiting[pair]
        taken, tasks[:] = tasks[:episodes], tasks[episodes:]
        if not tasks:
            del self._waiting[pair]
        self._flying[pair] += len(taken)
        facts = self._about.get(choice.name, {})
        how = {name: bool(facts.get(name)) for name in ("isolated", "privileged")}
        return Job(choice, scenario, tuple(taken), {t: self._bounds[t] for t in taken if t in self._bounds}, **how)


def missing_jobs(experiment: Experiment, finished: set[tuple[str, Task]], workers: int) -> Iterator[Job]:
    """Yield the missing episodes in jobs of one policy and one scenario, sized for a number of workers."""
    return iter(Workload(experiment, finished, workers))


def _size(scenario: Scenario, seed: int) -> _Size:
    cells = draw_floorplan(scenario, seed).truth.size
    steps = scenario.budget_for(cells) * scenario.team
    return _Size(steps * math.sqrt(cells), max(1, min(JOB_EPISODES, JOB_WORK // (cells * steps))))
