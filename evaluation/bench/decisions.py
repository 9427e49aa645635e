"""What flying costs beside the decisions, and what a whole comparison and a training take."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from indoor_explorers.env import make_policy
from indoor_explorers.env.presets import scenario
from indoor_explorers.evaluation.bench.figure import median_of, seconds_of
from indoor_explorers.evaluation.compare import JOB_EPISODES, plan, run
from indoor_explorers.evaluation.experiment import Task
from indoor_explorers.evaluation.record import Record
from indoor_explorers.evaluation.runner import fly
from indoor_explorers.evaluation.training import find_learner

#: Steps an episode that the DDDQN learns from has on average.
TRAINING_STEPS = 70


def overhead(policy: str) -> float:
    """Return what flying costs beside a policy's own decisions, as a percentage of their time, on ``thesis-obstacles``.

    Views, checks, the step of the world with its scan, and the log, in batches as comparisons fly them.
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
    planned = plan(policies=["frontier-nearest"], scenario=scenario("thesis-obstacles"), episodes=episodes)
    with tempfile.TemporaryDirectory() as folder:
        return seconds_of(lambda: run(planned, Path(folder) / "out"))


def training_time(episodes: int) -> float:
    """Return the seconds in which the DDDQN learns from so many episodes of ``thesis-obstacles``."""
    learner = find_learner("dddqn")
    config = learner.TrainingConfig(total_steps=TRAINING_STEPS * episodes)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        seconds = seconds_of(lambda: learner.train(config, scenario("thesis-obstacles"), out, seed=1))
        flown: int = json.loads((out / "training.json").read_text())["episodes"]
    return seconds * episodes / flown
