"""Benchmarks of the overhead besides decisions, of a whole comparison, and of a training."""

from __future__ import annotations

import json
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Literal, NamedTuple

from indoor_explorers.env import make_policy
from indoor_explorers.env.scenarios.presets import scenario
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.driver import run
from indoor_explorers.evaluation.harness.engines.workload import JOB_EPISODES
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.studies.bench.figure import median_of, seconds_of
from indoor_explorers.evaluation.studies.training import find_learner, nested

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
