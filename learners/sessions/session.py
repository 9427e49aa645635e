"""The session around any training: when it is evaluated, written and reported, and how it is resumed and interrupted.

A folder holds ``training.json``, the trained network, and a checkpoint with everything that a resumed training needs.
The record is written before the checkpoint: evaluations later than the checkpoint are repeated.
"""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.provenance import RECORD
from indoor_explorers.learners.sessions.process import deferred_interrupt
from indoor_explorers.learners.sessions.record import TrainingRecord, existing_record, write_record
from indoor_explorers.learners.sessions.settings import LearnerSettings

#: Seconds between two reports.
REPORT_EVERY = 0.5


@dataclass(frozen=True, kw_only=True)
class TrainingStatus:
    """The status that a trainee reports."""

    total_steps: int
    """Moves of the whole training; an estimate where the length is given in episodes."""
    counted: str = "steps"
    """Noun for ``steps``, for learners that do not count moves."""
    epsilon: float | None = None
    """Current probability of a random move; None for learners with a stochastic policy."""
    loss: float = math.nan
    """Mean loss since the last report, or the library's latest loss; NaN before the first update."""
    episodes: int | None = None
    """Training episodes so far; None where they are not counted."""
    episode_steps: float = math.nan
    """Mean steps of the training episodes that ended since the last report; NaN if none did."""


@dataclass(frozen=True, kw_only=True)
class Progress(TrainingStatus):
    """Progress of a training."""

    steps: int
    """Moves made, all environments together."""
    steps_per_second: float
    """Moves per second since the training was started or resumed, evaluations included."""
    evaluation: Mapping[str, int | float] | None
    """Results of the latest evaluation by name; None before the first one."""


class Trainee(ABC):
    """The interface of a learner in training to its session."""

    #: Unit of the intervals between evaluations and checkpoints: the name of an attribute and of an evaluation's entry.
    unit: ClassVar[str] = "steps"

    @property
    @abstractmethod
    def steps(self) -> int:
        """Moves made, or other units: see :attr:`TrainingStatus.counted`."""

    @property
    @abstractmethod
    def done(self) -> bool:
        """Tell whether the training is complete."""

    def update(self) -> None:
        """Make some moves and learn from them; a Ctrl-C takes effect only after it."""
        raise NotImplementedError

    def train(self, session: Session) -> None:
        """Train until :attr:`done` or until a Ctrl-C; overridden where a library brings its own training loop."""
        while not self.done and not session.interrupted:
            self.update()
            session.after_update(self)
            session.report(self)

    @abstractmethod
    def status(self) -> TrainingStatus:
        """Return the current status for a report."""

    @abstractmethod
    def evaluate(self) -> dict[str, int | float]:
        """Fly greedily on episodes that training does not use; return the results by name.

        This must not change the state of the training.
        """

    def rank(self, evaluation: Mapping[str, int | float]) -> tuple[float, ...]:
        """Return the key that evaluations are compared by, the lowest is best; by default all are alike."""
        return ()

    def keep(self, folder: Path) -> None:  # noqa: B027  # a hook
        """Write the current network into the folder as the best so far; not needed where :meth:`save` writes it."""

    @abstractmethod
    def save(self, folder: Path) -> None:
        """Write the checkpoint: everything that a resumed training needs."""

    def results(self) -> dict[str, Any]:
        """Return further entries of the record by name."""
        return {}


class Session:
    """Run one training in the folder ``out``.

    Args:
        record: The record of the training.
        config: Its hyperparameters.
        out: Its folder, which is created.
        checkpoint: Name of the learner's checkpoint in the folder.
        resume: Continue the training that the folder holds, if there is one.
        report: Called with the progress about twice a second.

    Raises:
        InputError: ``out`` holds another training, or one and ``resume`` is not set, or cannot be created.

    """

    def __init__(
        self,
        record: TrainingRecord,
        config: LearnerSettings,
        out: Path,
        checkpoint: str,
        *,
        resume: bool,
        report: Callable[[Progress], None] | None,
    ) -> None:
        self.record, self.out = record, out
        self.checkpoint: Path | None = None
        """The checkpoint to resume from; None for a new training."""
        self.listeners = [] if report is None else [report]
        """Called with the progress about twice a second."""
        self._config = config
        self._evaluations: list[dict[str, int | float]] = []
        self._interrupted = threading.Event()
        self._first_step = self._count = 0
        self._seconds_before, self._began, self._reported = 0.0, 0.0, -math.inf
        self._open(checkpoint, resume=resume)

    def _open(self, checkpoint: str, *, resume: bool) -> None:
        there = (self.out / checkpoint).exists()
        if not resume and (there or (self.out / RECORD).exists()):
            raise InputError(f"{self.out} already holds a training; give --resume to continue it, or another --out")
        before = existing_record(self.record, self._config, self.out)
        if there:
            if before is None:
                raise InputError(f"{self.out}: expected {RECORD} beside {checkpoint}, found none; give another --out")
            self.record = self.record.model_copy(update=self.record.continued_from(before))
            self.checkpoint = self.out / checkpoint
        try:
            self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.out}: cannot create the folder of the training: {error.strerror}") from error

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C was pressed."""
        return self._interrupted.is_set()

    def run(self, trainee: Trainee) -> None:
        """Train to the end, then evaluate and write everything; after a Ctrl-C write everything at once.

        Raises :class:`KeyboardInterrupt` after a Ctrl-C, when everything is written.
        """
        self._first_step, self._count = trainee.steps, self._counted(trainee)
        self._evaluations = [each for each in self.record.evaluations if each[trainee.unit] <= self._count]
        self._seconds_before, self._began = self.record.seconds, time.monotonic()
        with deferred_interrupt() as self._interrupted:
            trainee.train(self)
            if self.interrupted:
                self.write(trainee)
                raise KeyboardInterrupt
            if not self._evaluations or self._evaluations[-1][trainee.unit] < self._counted(trainee):
                self._evaluate(trainee)
            self.write(trainee)
            self._show(trainee)

    def after_update(self, trainee: Trainee) -> None:
        """Evaluate and write a checkpoint if due; :meth:`run` does so at the end of the training."""
        if trainee.done:
            return
        before, self._count = self._count, self._counted(trainee)
        if crossed_multiple(before, self._count, self._config.evaluation_every):
            self._evaluate(trainee)
        if crossed_multiple(before, self._count, self._config.checkpoint_every):
            self.write(trainee)

    def report(self, trainee: Trainee) -> None:
        """Report the progress if the last report is :data:`REPORT_EVERY` seconds old."""
        if time.monotonic() - self._reported >= REPORT_EVERY:
            self._show(trainee)

    @staticmethod
    def _counted(trainee: Trainee) -> int:
        return int(getattr(trainee, trainee.unit))

    def _show(self, trainee: Trainee) -> None:
        self._reported = time.monotonic()
        progress = Progress(
            **vars(trainee.status()),
            steps=trainee.steps,
            steps_per_second=(trainee.steps - self._first_step) / max(self._reported - self._began, 1e-9),
            evaluation=self._evaluations[-1] if self._evaluations else None,
        )
        for listener in self.listeners:
            listener(progress)

    def _evaluate(self, trainee: Trainee) -> None:
        """Evaluate the network, and keep it if it is the best so far."""
        found = trainee.evaluate()
        if all(trainee.rank(found) <= trainee.rank(other) for other in self._evaluations):
            trainee.keep(self.out)
        self._evaluations.append(found)
        self._write_record(trainee)

    def write(self, trainee: Trainee) -> None:
        """Write the record and the checkpoint."""
        if not self._evaluations:
            trainee.keep(self.out)
        self._write_record(trainee)
        trainee.save(self.out)

    def _write_record(self, trainee: Trainee) -> None:
        now = {
            "done": trainee.done and not self.interrupted,
            "seconds": round(self._seconds_before + time.monotonic() - self._began, 1),
            "steps": trainee.steps,
            "evaluations": tuple(self._evaluations),
        }
        self.record = self.record.model_copy(update=now)
        write_record(self.record, self.out, trainee.results())


def crossed_multiple(before: int, after: int, every: int) -> bool:
    """Tell whether a count has reached or passed a multiple of ``every``."""
    return before // every < after // every
