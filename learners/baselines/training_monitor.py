"""The books of one training: what it has reached, and when what is reported, evaluated and written."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.baselines.config import BaselineConfig
from indoor_explorers.learners.baselines.evaluation import evaluate
from indoor_explorers.learners.baselines.record import RECORD, Record, read_record, refuse_others, write_record
from indoor_explorers.learners.sessions.seeds import trial_seeds
from indoor_explorers.learners.sessions.session import Progress, one_thread, opened, passed, patience

#: Seconds between two reports.
REPORT_EVERY = 0.5


class Trainee(Protocol):
    """A model of some library in training."""

    @property
    def steps(self) -> int:
        """Moves made."""

    @property
    def loss(self) -> float:
        """The latest loss, not a number before the first one."""

    @property
    def epsilon(self) -> float | None:
        """Probability of a random move, where the learner has one."""

    def scores(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (B, 5) numbers, the higher the better, for observations (B, D)."""

    def keep(self) -> None:
        """Write the model as the one to fly."""

    def save(self) -> None:
        """Write the checkpoint, everything that it takes to go on."""


class Books:
    """Keep the books of one training in the folder ``out``."""

    def __init__(
        self,
        record: Record,
        config: BaselineConfig,
        scenario: Scenario,
        out: Path,
        report: Callable[[Progress], None] | None,
    ) -> None:
        self.record, self.config, self.out = record, config, out
        self.task = config.task(scenario)
        self._trials = record.trials
        self._report = report or (lambda progress: None)
        self._interrupted = threading.Event()
        self._first = self._seen = 0
        self._began, self._reported = time.monotonic(), -math.inf

    @classmethod
    def opened(
        cls,
        mine: Record,
        config: BaselineConfig,
        scenario: Scenario,
        out: Path,
        checkpoint: str,
        *,
        resume: bool,
        report: Callable[[Progress], None] | None,
    ) -> Books:
        """Open the folder of a new training, or of one to go on with, where it has got to a checkpoint.

        Raises:
            InputError: it holds another training, or one that was not asked to be resumed, or cannot be written.

        """
        if opened(out, RECORD, resume=resume):
            before = read_record(out)
            refuse_others(before, mine, out / RECORD)
            if (out / checkpoint).exists():
                mine = mine.model_copy(update={"steps": before.steps, "evaluations": before.evaluations})
        return cls(mine, config, scenario, out, report)

    @property
    def resumed(self) -> bool:
        """Whether the training goes on from a checkpoint."""
        return self.record.steps > 0

    @property
    def interrupted(self) -> bool:
        """Whether somebody pressed Ctrl-C."""
        return self._interrupted.is_set()

    @contextmanager
    def kept(self, trainee: Trainee) -> Iterator[None]:
        """Train inside of this; at the end, or after a Ctrl-C, everything is written.

        Raises:
            KeyboardInterrupt: after a Ctrl-C.

        """
        self._first = self._seen = trainee.steps
        self._began = time.monotonic()
        with one_thread(), patience() as self._interrupted:
            yield
            if self.interrupted:
                self._write(trainee)
                raise KeyboardInterrupt
            if not self._trials or self._trials[-1].steps < trainee.steps:
                self._evaluate(trainee)
            self._write(trainee)
            self._show(trainee)

    def between_updates(self, trainee: Trainee) -> None:
        """Evaluate and write what is due."""
        before, self._seen = self._seen, trainee.steps
        if passed(before, trainee.steps, self.config.evaluation_every):
            self._evaluate(trainee)
        if passed(before, trainee.steps, self.config.checkpoint_every):
            self._write(trainee)

    def report(self, trainee: Trainee) -> None:
        """Report the progress now and then."""
        if time.monotonic() - self._reported >= REPORT_EVERY:
            self._show(trainee)

    def _show(self, trainee: Trainee) -> None:
        self._reported = time.monotonic()
        self._report(
            Progress(
                steps=trainee.steps,
                total_steps=self.config.total_steps,
                epsilon=trainee.epsilon,
                loss=trainee.loss,
                steps_per_second=(trainee.steps - self._first) / max(self._reported - self._began, 1e-9),
                trial=self._trials[-1] if self._trials else None,
            )
        )

    def _evaluate(self, trainee: Trainee) -> None:
        """Evaluate the model, and keep it when it is the best so far."""
        trial = evaluate(
            trainee.scores,
            self.config.recipe,
            self.task,
            self.config.evaluation_episodes,
            trial_seeds(self.record.seed),
            trainee.steps,
        )
        if all((trial.t_goal, trial.t90) <= (other.t_goal, other.t90) for other in self._trials):
            trainee.keep()
        self._trials.append(trial)
        self._write_record(trainee)

    def _write(self, trainee: Trainee) -> None:
        trainee.save()
        if not self._trials:
            trainee.keep()
        self._write_record(trainee)

    def _write_record(self, trainee: Trainee) -> None:
        trials = tuple(trial._asdict() for trial in self._trials)
        self.record = self.record.model_copy(update={"steps": trainee.steps, "evaluations": trials})
        write_record(self.record, self.out)
