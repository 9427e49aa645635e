"""What it costs to fly a policy isolated: the same episodes, isolated and not, in turns."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from indoor_explorers.env import Briefing, Pilot, Policy, View, make_policy
from indoor_explorers.env.policies.view import Message
from indoor_explorers.env.scenarios.presets import scenario
from indoor_explorers.evaluation.bench.figure import REPEATS, seconds_of
from indoor_explorers.evaluation.engines.supervisor import Supervisor
from indoor_explorers.evaluation.episodes.record import FlownEpisode
from indoor_explorers.evaluation.experiment.experiment import Job, PolicyChoice, Task
from indoor_explorers.evaluation.experiment.limits import limits_for


class _PacedPilot(Pilot):
    """Decides as another pilot does, but not before its time is up."""

    def __init__(self, pilot: Pilot, seconds: float) -> None:
        self._pilot, self._seconds = pilot, seconds

    def act(self, view: View) -> int:
        """Choose as the other pilot does."""
        due = time.perf_counter() + self._seconds
        action = self._pilot.act(view)
        self.message: Message = self._pilot.message
        while time.perf_counter() < due:
            pass
        return action


@dataclass(frozen=True, kw_only=True)
class Paced(Policy):
    """``frontier-nearest``, whose decisions take a given time at least."""

    seconds: float = 0.0
    """Least seconds of a decision."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return _PacedPilot(make_policy("frontier-nearest").pilot(briefing), self.seconds)


def isolation_time(preset: str, pace: float, episodes: int) -> float:
    """Return the microseconds by which a decision is later when the policy is isolated.

    Decisions take ``pace`` seconds at least. Of several flights of a job of ``episodes``, the fastest counts.
    """
    task = scenario(preset).for_evaluation()
    choice = PolicyChoice(use=f"{Paced.__module__}:Paced", name="paced", parameters={"seconds": pace})
    tasks = tuple(Task(task.name, 0, seed) for seed in range(episodes))
    jobs = [Job(choice, task, tasks, isolated=isolated) for isolated in (False, True)]
    supervisors = [Supervisor(limits_for(1, None, None)) for _ in jobs]
    try:
        flown = [supervisor.fly(job) for supervisor, job in zip(supervisors, jobs, strict=True)]  # compiles
        rounds = [
            [seconds_of(partial(supervisor.fly, job)) for supervisor, job in zip(supervisors, jobs, strict=True)]
            for _ in range(REPEATS)
        ]
    finally:
        for supervisor in supervisors:
            supervisor.close()
    together, isolated = (min(seconds) for seconds in zip(*rounds, strict=True))
    return float(1e6 * (isolated - together) / _decisions(flown[0]))


def _decisions(records: Sequence[FlownEpisode]) -> int:
    return sum(record.steps * record.team for record in records)
