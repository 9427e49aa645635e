"""Runs the trainings of a study, each in a process of its own, several at a time; finished ones are not repeated.

The record in a folder (:mod:`indoor_explorers.learners.sessions.record`) says whether its training is finished, or
another one. A failure does not end the others. Run as a module, this is the process of one training.
"""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import IO, Any, NamedTuple

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.evaluation.studies.training import configured, find_learner, run_training

#: Seconds between two checks of the processes.
CHECK_INTERVAL = 0.2
#: Environment variables of the number of threads; every process uses one.
THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
COMMAND = (sys.executable, "-P", "-m", "indoor_explorers.evaluation.studies.many_trainings")


class Training(NamedTuple):
    """One training of a study."""

    learner: str
    scenario: str | None
    """Name or file of the scenario; None for a learner that draws its own maps and tasks."""
    variant: str
    """Name of the variant or experiment in the study."""
    seed: int
    settings: dict[str, Any]
    """Settings that differ from the learner's defaults, by dotted keys."""
    folder: str
    """The folder of the training."""

    @property
    def title(self) -> str:
        """Its name in tables and messages."""
        return f"{self.variant}, seed {self.seed}"

    def finished(self) -> Any:
        """Return the record in the folder if the training is finished, None if it is not.

        Raises:
            InputError: the folder holds another training, or there is no such learner, scenario or setting.

        """
        config = configured(self.learner, self.settings)
        return find_learner(self.learner).train.finished(config, self.task(), Path(self.folder), seed=self.seed)

    def task(self) -> Scenario | None:
        """Return the scenario.

        Raises :class:`InputError` if there is none of the name.
        """
        return None if self.scenario is None else named_scenario(self.scenario)


class Failure(NamedTuple):
    """A training that failed."""

    training: Training
    reason: str


class TrainingProcess:
    """The process of one training; its progress is shown, or not."""

    def __init__(self, training: Training, *, shown: bool) -> None:
        self.training = training
        self._errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  # lives as long as the process
        self._process = subprocess.Popen(
            COMMAND,
            stdin=subprocess.PIPE,
            stdout=None if shown else subprocess.DEVNULL,
            stderr=self._errors,
            env={**os.environ, **dict.fromkeys(THREADS, "1")},
            start_new_session=True,  # a Ctrl-C reaches it once, through interrupt
        )
        assert self._process.stdin is not None
        with self._process.stdin as pipe:
            pipe.write(json.dumps(training._asdict()).encode())

    @property
    def over(self) -> bool:
        """Whether the process has ended."""
        return self._process.poll() is not None

    def failure(self) -> Failure | None:
        """Return why the training failed, None if it did not; only after the process has ended."""
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        self._errors.close()
        status = self._process.wait()
        return Failure(self.training, lines[-1] if lines else f"ended with status {status}") if status else None

    def interrupt(self) -> None:
        """Ask the training to write a checkpoint and stop."""
        if not self.over:
            self._process.send_signal(signal.SIGINT)

    def wait(self) -> None:
        """Wait for the end of the process."""
        self._process.wait()
        self._errors.close()

    def kill(self) -> None:
        """End the process at once."""
        self._process.kill()
        self.wait()


def matching(names: Collection[str], patterns: Sequence[str], kind: str) -> list[str]:
    """Return the names that match any of the patterns, as file names do; ``kind`` says what they name.

    Raises:
        InputError: a pattern matches none.

    """
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in names):
            raise InputError(f"no {kind} is called {pattern!r}{did_you_mean(pattern, names)}")
    return [name for name in names if any(fnmatchcase(name, pattern) for pattern in patterns)]


def write_rows(
    path: Path, columns: Sequence[str], rows: Iterable[Mapping[str, Any]], *, lineterminator: str = "\n"
) -> None:
    """Write a CSV file; cells that a row lacks are empty."""
    with written_whole(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, columns, restval="", lineterminator=lineterminator)
        table.writeheader()
        table.writerows(rows)


def train_all(trainings: Sequence[Training], jobs: int, tell: Callable[[str], None]) -> list[Failure]:
    """Run the unfinished trainings in order, ``jobs`` at a time, and return failures.

    A single job shows its progress. Ctrl-C lets the trainings write checkpoints.
    """
    waiting = [training for training in trainings if training.finished() is None][::-1]
    running: list[TrainingProcess] = []
    failures: list[Failure] = []
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                tell(f"{waiting[-1].title}: training, {len(waiting) - 1} more to go")
                running.append(TrainingProcess(waiting.pop(), shown=jobs == 1))
            time.sleep(CHECK_INTERVAL)
            for process in [process for process in running if process.over]:
                running.remove(process)
                failure = process.failure()
                failures += [failure] if failure else []
                tell(f"{process.training.title}: {failure.reason if failure else _took(process.training)}")
    finally:
        _stop(running)
    return failures


def _stop(running: Sequence[TrainingProcess]) -> None:
    """Let trainings write their checkpoints and end; another Ctrl-C kills them."""
    for process in running:
        process.interrupt()
    try:
        for process in running:
            process.wait()
    except KeyboardInterrupt:
        for process in running:
            process.kill()
        raise


def _took(training: Training) -> str:
    return f"trained in {training.finished().minutes:.1f} min"


def run(training: Training) -> None:
    """Run one training in this process, or resume it."""
    run_training(
        training.learner, training.task(), training.settings, out=Path(training.folder), seed=training.seed, resume=True
    )


def main() -> int:
    """Run the training that stdin describes; return the exit status."""
    try:
        run(Training(**json.load(sys.stdin)))
    except InputError as error:
        sys.stderr.write(" ".join(str(error).split()) + "\n")
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
