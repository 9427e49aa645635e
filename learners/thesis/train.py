"""Train the thesis's DDDQN: a session around :class:`indoor_explorers.learners.thesis.training.Training`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.sessions.checkpoint import CHECKPOINT
from indoor_explorers.learners.sessions.process import one_thread
from indoor_explorers.learners.sessions.record import TrainingRecord, record_facts
from indoor_explorers.learners.sessions.session import Progress, Session
from indoor_explorers.learners.sessions.tensors import WEIGHTS
from indoor_explorers.learners.thesis.config import MENDED, TrainingConfig
from indoor_explorers.learners.thesis.training import Training

__all__ = ["MENDED", "Progress", "TrainingConfig", "train"]


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
    record = TrainingRecord(**record_facts("dddqn-thesis", (), config, scenario, [config.task(scenario)], seed))
    session = Session(record, config, out, CHECKPOINT, resume=resume, report=report)
    with one_thread():
        training = Training(config, scenario, seed, session.checkpoint)
        session.run(training, training.update)
    return out / WEIGHTS
