"""The ``train`` function of all learners; each binds it to its :class:`TrainingMethod`."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.sessions.checkpoint import CHECKPOINT
from indoor_explorers.learners.sessions.process import one_thread
from indoor_explorers.learners.sessions.record import TrainingRecord
from indoor_explorers.learners.sessions.seeds import training_seeds
from indoor_explorers.learners.sessions.session import Progress, Session, Trainee
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS


class TrainingMethod(NamedTuple):
    """What :func:`train` needs to know about a learner."""

    record: Callable[[Any, Any, int], TrainingRecord]
    """Makes the record of a new training from its configuration, scenario and seed."""
    trainee: Callable[[Any, Any, int, Session], AbstractContextManager[Trainee]]
    """Makes the trainee from the same and the session; it is released at the end of the training."""
    checkpoint: str = CHECKPOINT
    """Name of the checkpoint in the training's folder."""
    weights: str = WEIGHTS
    """Name of the file in it that a policy loads."""


def train(
    method: TrainingMethod,
    config: Any,
    scenario: Scenario | None,
    out: Path,
    *,
    seed: int,
    resume: bool = False,
    report: Callable[[Progress], None] | None = None,
) -> Path:
    """Train a learner and return the path of the weights in the folder ``out``.

    Ctrl-C ends the current update, writes a checkpoint and raises :class:`KeyboardInterrupt`; a second one stops at
    once. Torch runs on one thread.

    Args:
        method: The learner.
        config: Its ``TrainingConfig``.
        scenario: The scenario to train on; None for a learner that draws its own.
        out: Folder of the training; it is created.
        seed: Seed of the whole training.
        resume: Continue the training that ``out`` holds, if there is one.
        report: Called with the progress about twice a second.

    Raises:
        InputError: The learner cannot train on the scenario, or ``out`` holds another training, a damaged one, or one
            and ``resume`` is not set.

    """
    training_seeds(seed)  # refuses a bad seed before the folder is made
    with one_thread():
        session = Session(
            method.record(config, scenario, seed), config, out, method.checkpoint, resume=resume, report=report
        )
        with method.trainee(config, scenario, seed, session) as trainee:
            session.run(trainee)
    return out / method.weights
