"""What it costs to fly a policy isolated: the same episodes, isolated and not, in turns."""

from __future__ import annotations

import time
from dataclasses import dataclass

from indoor_explorers.env import Briefing, Pilot, Policy, View, make_policy
from indoor_explorers.env.policies.view import Message
from indoor_explorers.env.scenarios.presets import scenario
from indoor_explorers.evaluation.harness.engines.supervisor import Supervisor
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode
from indoor_explorers.evaluation.harness.experiment.experiment import Job, PolicyChoice, Task
from indoor_explorers.evaluation.harness.experiment.limits import limits_for
from indoor_explorers.evaluation.studies.bench.figure import REPEATS, seconds_of


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
    """Return the microseconds that isolation adds to what is spent besides each decision.

    Decisions take ``pace`` seconds at least. Of several flights of a job of ``episodes``, that with the least counts.
    """
    task = scenario(preset).for_evaluation()
    choice = PolicyChoice(use=f"{Paced.__module__}:Paced", name="paced", parameters={"seconds": pace})
    tasks = tuple(Task(task.name, 0, seed) for seed in range(episodes))
    jobs = [Job(choice, task, tasks, isolated=isolated) for isolated in (False, True)]
    supervisors = [Supervisor(limits_for(1, None, None)) for _ in jobs]
    try:
        rounds = [
            [_besides(supervisor, job) for supervisor, job in zip(supervisors, jobs, strict=True)]
            for _ in range(1 + REPEATS)  # the first one compiles
        ]
    finally:
        for supervisor in supervisors:
            supervisor.close()
    together, isolated = (min(each) for each in zip(*rounds, strict=True))
    return float(1e6 * (isolated - together))


def _besides(supervisor: Supervisor, job: Job) -> float:
    """Return the seconds for each decision of a job that are not the decision's own."""
    records: list[FlownEpisode] = []
    seconds = seconds_of(lambda: records.extend(supervisor.fly(job)))
    deciding = sum(float(record.seconds[-1]) for record in records)
    return (seconds - deciding) / sum(record.steps * record.team for record in records)
