"""Train a DDDQN: the loop around :class:`indoor_explorers.learners.dddqn.learning.training.Training`."""

from __future__ import annotations

import json
import platform
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from indoor_explorers.env.files import written_whole
from indoor_explorers.env.provenance import source_commit, versions
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.ablations import ABLATION_SETTINGS, ABLATIONS, TEAM_ABLATIONS, flown
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.learning.tensorboard import Scalars
from indoor_explorers.learners.dddqn.learning.training import Training
from indoor_explorers.learners.dddqn.network.model import arrays
from indoor_explorers.learners.dddqn.observation.map_prior import prior_arrays
from indoor_explorers.learners.dddqn.presets import PRESETS
from indoor_explorers.learners.dddqn.weights import write_weights
from indoor_explorers.learners.sessions import session
from indoor_explorers.learners.sessions.session import noted, one_thread, opened, passed, patience
from indoor_explorers.learners.sessions.tensors import WEIGHTS

__all__ = [
    "ABLATIONS",
    "ABLATION_SETTINGS",
    "PRESETS",
    "TEAM_ABLATIONS",
    "Progress",
    "TrainingConfig",
    "flown",
    "train",
]

CHECKPOINT, RECORD = "checkpoint.safetensors", "training.json"
#: Packages that the result of a training depends on.
PACKAGES = ("indoor-explorers", "numpy", "numba", "torch")
#: Ticks between two reports.
REPORT_EVERY = 50


@dataclass(frozen=True, kw_only=True)
class Progress(session.Progress):
    """How far a training is, and how it is getting on."""

    episodes: int
    """Episodes begun."""
    episode_steps: float
    """Mean steps of the training episodes that ended since the last report; not a number when none did."""

    def scalars(self) -> dict[str, float]:
        """Return the figures by name, without those that are missing."""
        found = {f"training/{name}": getattr(self, name) for name in ("epsilon", "loss", "episode_steps")}
        found |= {"training/episodes": self.episodes, "training/steps_per_second": self.steps_per_second}
        if self.trial is not None:
            found |= {f"evaluation/{name}": value for name, value in self.trial._asdict().items() if name != "steps"}
        return {name: float(value) for name, value in found.items() if not np.isnan(value)}


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

    Writes ``weights.safetensors`` (the averaged weights that did best in evaluation), ``training.json``
    (configuration, seed, versions, commits, evaluations) and ``checkpoint.safetensors`` (everything, to
    resume from). Ctrl-C finishes the tick, writes a checkpoint and raises :class:`KeyboardInterrupt`; a
    second one stops at once. The same seed gives the same weights, resumed or not: torch runs on one thread.

    Raises:
        InputError: ``out`` holds another training, or one that was not asked to be resumed.

    """
    checkpoint = out / CHECKPOINT if opened(out, CHECKPOINT, resume=resume) else None
    with one_thread(), patience() as interrupted:
        training = Training(config, scenario, seed, checkpoint)
        training.commits = noted(training.commits, source_commit())
        with Scalars(out) as scalars:

            def tell(progress: Progress) -> None:
                scalars.write(progress.steps, progress.scalars())
                if report is not None:
                    report(progress)

            _loop(training, scenario, out, tell, interrupted)
    return out / WEIGHTS


def _loop(
    training: Training,
    scenario: Scenario,
    out: Path,
    report: Callable[[Progress], None],
    interrupted: threading.Event,
) -> None:
    config = training.config
    began, first, ticks = time.monotonic(), training.steps, 0
    while not training.done:
        before = training.steps
        training.tick()
        ticks += 1
        if passed(before, training.steps, config.evaluation_every) or training.done:
            training.take_trial()
        if passed(before, training.steps, config.checkpoint_every) or interrupted.is_set():
            _write(training, scenario, out)
        if interrupted.is_set():
            raise KeyboardInterrupt
        if ticks % REPORT_EVERY == 0 or training.done:
            report(_progress(training, (training.steps - first) / (time.monotonic() - began)))
    _write(training, scenario, out)


def _progress(training: Training, speed: float) -> Progress:
    loss, episode_steps = (float(np.mean(past)) if past else float("nan") for past in (training.losses, training.ended))
    training.losses.clear()
    training.ended.clear()
    return Progress(
        steps=training.steps,
        total_steps=training.config.total_steps,
        episodes=training.episodes,
        epsilon=training.config.epsilon(training.share),
        loss=loss,
        episode_steps=episode_steps,
        steps_per_second=speed,
        trial=training.trials[-1] if training.trials else None,
    )


def _write(training: Training, scenario: Scenario, out: Path) -> None:
    """Write checkpoint, weights and record, each in one go."""
    training.save(out / CHECKPOINT)
    best = training.learner.best if training.trials else training.learner.average
    write_weights(
        out / WEIGHTS,
        arrays(best),
        prior_arrays(training.prior),
        training.config.observation,
        training.config.network,
    )
    with written_whole(out / RECORD) as partial:
        partial.write_text(json.dumps(_record(training, scenario), indent=2) + "\n", encoding="utf-8")


def _record(training: Training, scenario: Scenario) -> dict[str, Any]:
    return {
        "policy": "dddqn",
        "seed": training.seed,
        "scenario": scenario.model_dump(mode="json"),
        "fingerprint": scenario.fingerprint,
        "config": training.config.model_dump(mode="json"),
        "versions": {"python": platform.python_version()} | versions(PACKAGES),
        "commit": training.commits[0],
        "commits": training.commits,
        "steps": training.steps,
        "episodes": training.episodes,
        "evaluations": [trial._asdict() for trial in training.trials],
    }
