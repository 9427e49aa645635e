"""Train the thesis's DDDQN: the loop around :class:`indoor_explorers.learners.thesis.training.Training`."""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from indoor_explorers.env.files import written_whole
from indoor_explorers.env.provenance import source_commit, versions
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.sessions import session
from indoor_explorers.learners.sessions.session import noted, one_thread, opened, passed, patience
from indoor_explorers.learners.sessions.tensors import WEIGHTS
from indoor_explorers.learners.thesis.config import MENDED, TrainingConfig
from indoor_explorers.learners.thesis.training import Training
from indoor_explorers.learners.thesis.weights import write_weights

__all__ = ["MENDED", "RECORD", "Progress", "TrainingConfig", "train"]

CHECKPOINT, RECORD, EPISODES = "checkpoint.safetensors", "training.json", "episodes.csv"
#: Packages that the result of a training depends on.
PACKAGES = ("indoor-explorers", "numpy", "numba", "torch")
#: Seconds between two reports.
REPORT_EVERY = 0.5


@dataclass(frozen=True, kw_only=True)
class Progress(session.Progress):
    """How far a training is; ``total_steps`` is a guess, since the number of episodes is what is fixed."""

    episodes: int
    """Episodes that are over."""


def train(
    config: TrainingConfig,
    scenario: Scenario,
    out: Path,
    *,
    seed: int,
    resume: bool = False,
    report: Callable[[Progress], None] | None = None,
) -> Path:
    """Train on a scenario and return the path of the weights in the folder ``out``.

    Writes ``weights.safetensors`` (the network as it is at the end, as the thesis's), ``episodes.csv`` (every
    training episode: the thesis's curve), ``training.json`` (configuration, seed, versions, commits, evaluations)
    and ``checkpoint.safetensors`` (everything, to resume from). Ctrl-C finishes the move, writes a checkpoint and
    raises :class:`KeyboardInterrupt`; a second one stops at once. The same seed gives the same weights, resumed or
    not.

    Raises:
        InputError: ``out`` holds another training, or one that was not asked to be resumed.

    """
    with one_thread(), patience() as interrupted:
        training = Training(config, scenario, seed)
        if opened(out, CHECKPOINT, resume=resume):
            training.load(out / CHECKPOINT)
        training.commits = noted(training.commits, source_commit())
        clock = _Clock(training, report or (lambda progress: None))
        while not training.done:
            before = training.episodes
            training.tick()
            if passed(before, training.episodes, config.evaluation_every) or training.done:
                training.take_trial()
            if passed(before, training.episodes, config.checkpoint_every) or interrupted.is_set():
                _write(training, scenario, out, clock.seconds)
            if interrupted.is_set():
                raise KeyboardInterrupt
            clock.tell()
        _write(training, scenario, out, clock.seconds)
    return out / WEIGHTS


class _Clock:
    """Report now and then how far a training is."""

    def __init__(self, training: Training, report: Callable[[Progress], None]) -> None:
        self._training, self._report = training, report
        self._began = self._told = time.monotonic()
        self._first = training.steps

    @property
    def seconds(self) -> float:
        """Seconds since the training was started or resumed."""
        return time.monotonic() - self._began

    def tell(self) -> None:
        """Report when it is time, and at the end."""
        training, now = self._training, time.monotonic()
        if now - self._told < REPORT_EVERY and not training.done:
            return
        self._told = now
        loss = float(np.mean(training.losses)) if training.losses else float("nan")
        training.losses.clear()
        share = min(max(training.episodes, 1) / training.config.episodes, 1.0)
        self._report(
            Progress(
                steps=training.steps,
                total_steps=max(int(training.steps / share), 1),
                episodes=training.episodes,
                epsilon=training.config.epsilon(training.steps),
                loss=loss,
                steps_per_second=(training.steps - self._first) / max(self.seconds, 1e-9),
                trial=training.trials[-1] if training.evaluations else None,
            )
        )


def _write(training: Training, scenario: Scenario, out: Path, seconds: float) -> None:
    """Write checkpoint, weights, episodes and record, each in one go."""
    training.save(out / CHECKPOINT, seconds)
    write_weights(out / WEIGHTS, training.learner.arrays(), training.eye)
    training.history.write(out / EPISODES, training.config.episodes)
    with written_whole(out / RECORD) as partial:
        partial.write_text(json.dumps(_record(training, scenario, seconds), indent=1) + "\n", encoding="utf-8")


def _record(training: Training, scenario: Scenario, seconds: float) -> dict[str, Any]:
    return {
        "policy": "dddqn-thesis",
        "seed": training.seed,
        "scenario": scenario.model_dump(mode="json"),
        "fingerprint": scenario.fingerprint,
        "config": training.config.model_dump(mode="json"),
        "versions": {"python": platform.python_version()} | versions(PACKAGES),
        "commit": training.commits[0],
        "commits": training.commits,
        "done": training.done,
        "seconds": round(training.seconds + seconds, 1),
        "steps": training.steps,
        "episodes": training.episodes,
        "evaluations": [trial._asdict() for trial in training.trials],
        "training_coverage_by_step": training.history.by_step(),
        "greedy_coverage_by_step": training.evaluations[-1].by_step if training.evaluations else [],
    }
