"""Train a DDDQN: a session around :class:`indoor_explorers.learners.dddqn.learning.training.Training`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.ablations import ABLATION_SETTINGS, ABLATIONS, TEAM_ABLATIONS, flown
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.learning.tensorboard import Scalars
from indoor_explorers.learners.dddqn.learning.training import Training
from indoor_explorers.learners.dddqn.presets import PRESETS
from indoor_explorers.learners.sessions.checkpoint import CHECKPOINT
from indoor_explorers.learners.sessions.process import one_thread
from indoor_explorers.learners.sessions.record import TrainingRecord, record_facts
from indoor_explorers.learners.sessions.session import Progress, Session
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
    scalars = Scalars(out)

    def tell(progress: Progress) -> None:
        scalars.write(progress)
        if report is not None:
            report(progress)

    record = TrainingRecord(**record_facts("dddqn", (), config, scenario, config.tasks(scenario), seed))
    session = Session(record, config, out, CHECKPOINT, resume=resume, report=tell)
    with one_thread(), scalars:
        training = Training(config, scenario, seed, session.checkpoint)
        session.run(training, training.update)
    return out / WEIGHTS
