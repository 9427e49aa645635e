"""Benchmarks of the start of a process, of overhead and isolation besides decisions, of a comparison and a training."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal, NamedTuple

from indoor_explorers.env import Briefing, Pilot, Policy, View, make_policy
from indoor_explorers.env.policies.view import Message
from indoor_explorers.env.scenarios.presets import scenario
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.driver import run
from indoor_explorers.evaluation.harness.engines.supervisor import Supervisor
from indoor_explorers.evaluation.harness.engines.workload import JOB_EPISODES
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode, Record
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Job, PolicyChoice, Task
from indoor_explorers.evaluation.harness.experiment.limits import limits_for
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.studies.bench.figure import REPEATS, median_of, seconds_of
from indoor_explorers.evaluation.studies.training import find_learner, nested

FIRST_STEP = (
    "from indoor_explorers.env import World, scenario; import numpy as np;"
    "w = World(scenario('thesis-team-4')); w.reset([0]); w.step(np.zeros((1, 4), int))"
)
FIRST_EPISODE = (
    "from indoor_explorers.env import make_policy, scenario;"
    "from indoor_explorers.evaluation.harness.episodes.runner import fly;"
    "from indoor_explorers.evaluation.harness.experiment.experiment import Task;"
    "task = scenario('thesis-obstacles').for_evaluation();"
    "list(fly(make_policy('frontier-nearest'), 'frontier-nearest', task, [Task(task.name, 0, 0)]))"
)
#: Environment variable with the folder of the compile cache.
CACHE = "NUMBA_CACHE_DIR"


def first_compile() -> float:
    """Return the seconds from an empty compile cache to the first flown episode, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        return _seconds(FIRST_EPISODE, {CACHE: folder})


def first_step() -> float:
    """Return the seconds from the start of a process to the first step of a world when everything is compiled."""
    return median_of(lambda: _seconds(FIRST_STEP, {}))


def _seconds(program: str, variables: dict[str, str]) -> float:
    """Return the seconds that a new process takes for a program, including its start."""
    command, variables = [sys.executable, "-P", "-c", program], os.environ | variables
    return seconds_of(lambda: subprocess.run(command, check=True, env=variables, capture_output=True))


#: Average number of moves in an episode that the DDDQN learns from, rounded up.
TRAINING_STEPS = 52


def overhead(policy: str) -> float:
    """Return the time of flying besides a policy's decisions, in percent of these, on ``thesis-obstacles``.

    It is made up of views, checks, the steps of the world with their scans, and the log, in batches as in comparisons.
    """
    task, pilot = scenario("thesis-obstacles").for_evaluation(), make_policy(policy)

    def share() -> float:
        records: list[Record] = []
        batch = [Task(task.name, 0, seed) for seed in range(JOB_EPISODES)]
        seconds = seconds_of(lambda: records.extend(fly(pilot, policy, task, batch)))
        own = sum(record.metrics["latency_total_s"] or 0.0 for record in records)
        return 100.0 * (seconds - own) / own

    return median_of(share)


def comparison_time(episodes: int) -> float:
    """Return the seconds of a whole comparison with ``frontier-nearest``: workers, store, table and report."""
    request = ComparisonRequest(policies=["frontier-nearest"], scenario="thesis-obstacles", episodes=episodes)
    with tempfile.TemporaryDirectory() as folder:
        return seconds_of(lambda: run(plan(request), Path(folder) / "out"))


class TrainingCost(NamedTuple):
    """The results of a training."""

    seconds: float
    """Seconds for the requested number of episodes, evaluations included."""
    t90: float
    """Mean steps to 90 % at the last evaluation: greedy, without guard, on maps not used in training."""


def trained(part: Literal["seconds", "t90"], preset: str, episodes: int) -> float:
    """Return one result of training the DDDQN with a preset on about this number of episodes."""
    return float(getattr(_trained(preset, episodes), part))


@lru_cache(maxsize=2)
def _trained(name: str, episodes: int) -> TrainingCost:
    """Train the DDDQN with a preset on about this number of episodes."""
    learner = find_learner("dddqn")
    preset = learner.PRESETS[name]
    settings = {**preset.settings, "total_steps": TRAINING_STEPS * episodes}
    config = validated(learner.TrainingConfig, nested(settings), "settings of the bench")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        seconds = seconds_of(lambda: learner.train(config, scenario(preset.scenario), out, seed=preset.seed))
        record = json.loads((out / "training.json").read_text())
    return TrainingCost(seconds * episodes / record["episodes"], record["evaluations"][-1]["t90"])


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
