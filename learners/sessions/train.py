"""The ``train`` function of all learners: a :class:`TrainingMethod` of each, in the module of its entry point."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.sessions.checkpoint import CHECKPOINT
from indoor_explorers.learners.sessions.process import one_thread
from indoor_explorers.learners.sessions.record import TrainingRecord, existing_record
from indoor_explorers.learners.sessions.seeds import training_seeds
from indoor_explorers.learners.sessions.session import Progress, Session, Trainee
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS


class TrainingMethod(NamedTuple):
    """A learner, as a function that trains it."""

    record: Callable[[Any, Any, int], TrainingRecord]
    """Makes the record of a new training from its configuration, scenario and seed."""
    trainee: Callable[[Any, Any, int, Session], AbstractContextManager[Trainee]]
    """Makes the trainee from the same and the session; it is released at the end of the training."""
    checkpoint: str = CHECKPOINT
    """Name of the checkpoint in the training's folder."""
    weights: str = WEIGHTS
    """Name of the file in it that a policy loads."""

    def __call__(
        self,
        config: Any,
        scenario: Scenario | None,
        out: Path,
        *,
        seed: int,
        resume: bool = False,
        report: Callable[[Progress], None] | None = None,
    ) -> Path:
        """Train and return the path of the weights in the folder ``out``.

        Ctrl-C ends the current update, writes a checkpoint and raises :class:`KeyboardInterrupt`; a second one stops
        at once. Torch runs on one thread.

        Args:
            config: The learner's ``TrainingConfig``.
            scenario: The scenario to train on; None for a learner that draws its own.
            out: Folder of the training; it is created.
            seed: Seed of the whole training.
            resume: Continue the training that ``out`` holds, if there is one.
            report: Called with the progress about twice a second.

        Raises:
            InputError: The learner cannot train on the scenario, or ``out`` holds another training, a damaged one, or
                one and ``resume`` is not set.

        """
        training_seeds(seed)  # refuses a bad seed before the folder is made
        with one_thread():
            record = self.record(config, scenario, seed)
            session = Session(record, config, out, self.checkpoint, resume=resume, report=report)
            with self.trainee(config, scenario, seed, session) as trainee:
                session.run(trainee)
        return out / self.weights

    def finished(self, config: Any, scenario: Scenario | None, out: Path, *, seed: int) -> TrainingRecord | None:
        """Return the record of the training in the folder ``out`` if it is finished, None if it is not.

        Raises :class:`InputError` if ``out`` holds another training, or a damaged one.
        """
        there = existing_record(self.record(config, scenario, seed), config, out)
        return there if there is not None and there.done else None
