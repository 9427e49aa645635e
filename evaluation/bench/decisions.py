"""What flying costs beside the decisions, and what a whole comparison and a training take."""

from __future__ import annotations

import json
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Literal, NamedTuple

from indoor_explorers.env import make_policy
from indoor_explorers.env.scenarios.presets import scenario
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.bench.figure import median_of, seconds_of
from indoor_explorers.evaluation.driver import run
from indoor_explorers.evaluation.engines.workload import JOB_EPISODES
from indoor_explorers.evaluation.episodes.record import Record
from indoor_explorers.evaluation.episodes.runner import fly
from indoor_explorers.evaluation.experiment.experiment import Task
from indoor_explorers.evaluation.experiment.planning import plan
from indoor_explorers.evaluation.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.training import find_learner, nested

#: Moves of an episode that the DDDQN learns from, on average and rounded up.
TRAINING_STEPS = 52


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
    request = ComparisonRequest(policies=["frontier-nearest"], scenario="thesis-obstacles", episodes=episodes)
    with tempfile.TemporaryDirectory() as folder:
        return seconds_of(lambda: run(plan(request), Path(folder) / "out"))


class TrainingCost(NamedTuple):
    """What came of a training."""

    seconds: float
    """What the asked number of episodes takes, evaluations included."""
    t90: float
    """Mean steps to 90 % at the last evaluation: greedy, no guard, on maps kept apart from training."""


def trained(part: Literal["seconds", "t90"], preset: str, episodes: int) -> float:
    """Return a figure of a training of the DDDQN as one of its presets does, on about this many episodes."""
    return float(getattr(_trained(preset, episodes), part))


@lru_cache(maxsize=2)
def _trained(name: str, episodes: int) -> TrainingCost:
    """Train the DDDQN as one of its presets does, on about this many episodes."""
    learner = find_learner("dddqn")
    preset = learner.PRESETS[name]
    settings = {**preset.settings, "total_steps": TRAINING_STEPS * episodes}
    config = validated(learner.TrainingConfig, nested(settings), "settings of the bench")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        seconds = seconds_of(lambda: learner.train(config, scenario(preset.scenario), out, seed=preset.seed))
        record = json.loads((out / "training.json").read_text())
    return TrainingCost(seconds * episodes / record["episodes"], record["evaluations"][-1]["t90"])
