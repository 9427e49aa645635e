"""The session around any training: when it is evaluated, written and reported, and how it is resumed and interrupted.

A folder holds ``training.json``, the network to fly, and a checkpoint with everything that it takes to go on. The
record is written before the checkpoint: evaluations that the checkpoint does not know of are made again.
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
from indoor_explorers.learners.sessions.process import deferred_interrupt
from indoor_explorers.learners.sessions.record import RECORD, TrainingRecord, read_record, write_record
from indoor_explorers.learners.sessions.settings import LearnerSettings

#: Seconds between two reports.
REPORT_EVERY = 0.5


@dataclass(frozen=True, kw_only=True)
class TrainingStatus:
    """What a learner tells of itself."""

    total_steps: int
    """Moves to make, as far as is known."""
    epsilon: float | None = None
    """Probability of a random move now; None for learners that draw from their policy."""
    loss: float = math.nan
    """Mean loss since the last report, or the latest that a library tells; not a number before the first update."""
    episodes: int | None = None
    """Episodes so far, where they are counted."""
    episode_steps: float = math.nan
    """Mean steps of the training episodes that ended since the last report; not a number when none did."""


@dataclass(frozen=True, kw_only=True)
class Progress(TrainingStatus):
    """How far a training is."""

    steps: int
    """Moves made, all environments together."""
    steps_per_second: float
    """Moves a second since the training was started or resumed, evaluations included."""
    evaluation: Mapping[str, int | float] | None
    """Figures of the latest evaluation."""


class Trainee(ABC):
    """A learner in training, as a session sees it."""

    #: What evaluations and checkpoints are due by: an attribute, and a figure of every evaluation.
    unit: ClassVar[str] = "steps"

    @property
    @abstractmethod
    def steps(self) -> int:
        """Moves made."""

    @property
    @abstractmethod
    def done(self) -> bool:
        """Tell whether the training has come to its end."""

    def update(self) -> None:
        """Fly and learn for a moment, which a Ctrl-C never interrupts."""
        raise NotImplementedError

    def train(self, session: Session) -> None:
        """Train to the end or to a Ctrl-C; a learner whose library has a loop of its own runs that one."""
        while not self.done and not session.interrupted:
            self.update()
            session.after_update(self)
            session.report(self)

    @abstractmethod
    def status(self) -> TrainingStatus:
        """Return what to report."""

    @abstractmethod
    def evaluate(self) -> dict[str, int | float]:
        """Fly greedily on episodes kept apart from training; return figures, lower ones in :meth:`rank` being better.

        Training must go on as if nothing had been flown.
        """

    @abstractmethod
    def rank(self, evaluation: Mapping[str, int | float]) -> tuple[float, ...]:
        """Return what the best evaluation has least of."""

    @abstractmethod
    def keep(self, folder: Path) -> None:
        """Keep the network as it is now as the best so far."""

    @abstractmethod
    def save(self, folder: Path) -> None:
        """Write the checkpoint, everything that it takes to go on."""

    def results(self) -> dict[str, Any]:
        """Return what else the record should say."""
        return {}


class Session:
    """Run one training in the folder ``out``.

    Args:
        record: How the training is made.
        config: Its hyperparameters.
        out: Its folder, which is made.
        checkpoint: Name of the learner's checkpoint in it.
        resume: Go on with the training that the folder holds, if there is one.
        report: Called with the progress now and then.

    Raises:
        InputError: ``out`` holds another training, or one that was not asked to be resumed, or cannot be made.

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
        """What to go on from; None for a training that begins."""
        self.listeners = [] if report is None else [report]
        """Called with the progress now and then."""
        self._config = config
        self._evaluations: list[dict[str, int | float]] = []
        self._interrupted = threading.Event()
        self._first_step = self._count = 0
        self._seconds_before, self._began, self._reported = 0.0, 0.0, -math.inf
        self._open(checkpoint, resume=resume)

    def _open(self, checkpoint: str, *, resume: bool) -> None:
        there = (self.out / checkpoint).exists()
        if there or (self.out / RECORD).exists():
            if not resume:
                raise InputError(
                    f"{self.out} already holds a training; give --resume to go on with it, or another --out"
                )
            before = read_record(self.out, type(self.record), [self.record.learner])
            carried = self.record.resumed(before, self.out / RECORD)
            if there:
                self.record = self.record.model_copy(update=carried)
                self.checkpoint = self.out / checkpoint
        try:
            self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.out}: cannot be made a folder for the training: {error.strerror}") from error

    @property
    def interrupted(self) -> bool:
        """Whether somebody pressed Ctrl-C."""
        return self._interrupted.is_set()

    def run(self, trainee: Trainee) -> None:
        """Train to the end; then, or after a Ctrl-C, write everything.

        Raises:
            KeyboardInterrupt: After a Ctrl-C, with everything written.

        """
        self._first_step, self._count = trainee.steps, self._counted(trainee)
        self._evaluations = [each for each in self.record.evaluations if each[trainee.unit] <= self._count]
        self._seconds_before, self._began = self.record.seconds, time.monotonic()
        with deferred_interrupt() as self._interrupted:
            trainee.train(self)
            if self.interrupted:
                self._write(trainee)
                raise KeyboardInterrupt
            if not self._evaluations or self._evaluations[-1][trainee.unit] < self._counted(trainee):
                self._evaluate(trainee)
            self._write(trainee)
            self._show(trainee)

    def after_update(self, trainee: Trainee) -> None:
        """Evaluate and write what is due; what is due at the end is left to :meth:`run`."""
        if trainee.done:
            return
        before, self._count = self._count, self._counted(trainee)
        if crossed_multiple(before, self._count, self._config.evaluation_every):
            self._evaluate(trainee)
        if crossed_multiple(before, self._count, self._config.checkpoint_every):
            self._write(trainee)

    def report(self, trainee: Trainee) -> None:
        """Report the progress now and then."""
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
        """Evaluate the network, and keep it when it is the best so far."""
        found = trainee.evaluate()
        if all(trainee.rank(found) <= trainee.rank(other) for other in self._evaluations):
            trainee.keep(self.out)
        self._evaluations.append(found)
        self._write_record(trainee)

    def _write(self, trainee: Trainee) -> None:
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
