"""Runs trainings in processes of their own, several at a time; a failure does not end the others."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from typing import IO, NamedTuple

from indoor_explorers.evaluation.studies.ablation.runs import TrainingRun, read_state

#: Seconds between two checks of the processes.
CHECK_INTERVAL = 0.2
#: Environment variables of the number of threads; every process uses one.
THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
COMMAND = (sys.executable, "-P", "-m", "indoor_explorers.evaluation.studies.ablation.worker")


class Failure(NamedTuple):
    """A training that failed."""

    run: TrainingRun
    reason: str


class TrainingProcess:
    """The process of one training."""

    def __init__(self, run: TrainingRun) -> None:
        self.run = run
        self._errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  # lives as long as the process
        self._process = subprocess.Popen(
            COMMAND,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            env={**os.environ, **dict.fromkeys(THREADS, "1")},
            start_new_session=True,  # a Ctrl-C reaches it once, through interrupt
        )
        assert self._process.stdin is not None
        with self._process.stdin as pipe:
            pipe.write(json.dumps(run._asdict()).encode())

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
        return Failure(self.run, lines[-1] if lines else f"ended with status {status}") if status else None

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


def train_all(runs: Sequence[TrainingRun], jobs: int, tell: Callable[[str], None]) -> list[Failure]:
    """Train the unfinished runs, ``jobs`` at a time, and return failures; Ctrl-C lets them write checkpoints."""
    waiting = [run for run in runs if "weights" not in read_state(run)][::-1]
    running: list[TrainingProcess] = []
    failures: list[Failure] = []
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                running.append(TrainingProcess(waiting.pop()))
                tell(f"{running[-1].run.title}: training, {len(waiting)} more to go")
            time.sleep(CHECK_INTERVAL)
            for process in [process for process in running if process.over]:
                running.remove(process)
                failure = process.failure()
                failures += [failure] if failure else []
                tell(f"{process.run.title}: {failure.reason if failure else _took(process.run)}")
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


def _took(run: TrainingRun) -> str:
    return f"trained in {read_state(run)['minutes']:.1f} min"
