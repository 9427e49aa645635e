"""What runs in a worker process: it flies the jobs it is sent and sends back their records.

It does not watch over the policies it flies; its driver does, see
:mod:`indoor_explorers.evaluation.engines.worker_handle`.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from numba.core import event

from indoor_explorers.env import Briefing, InputError, Pilot, Policy
from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.episodes.runner import BREAKING, describe_error, fly
from indoor_explorers.evaluation.episodes.shared_steps import Clock, SharedStepBuffer
from indoor_explorers.evaluation.experiment.experiment import Job

#: Seconds between two looks at whether the driver still lives.
LOOK_EVERY = 0.5
#: numba has no types for its events.
_Listener: Any = event.Listener
_register: Any = event.register


def serve(connection: Connection, buffer: SharedStepBuffer, driver: int) -> None:
    """Fly jobs until the connection closes: of each, send every record, then None; or what went wrong.

    Ctrl-C is left to the driver; when that is killed, the process leaves. What policies print goes to the standard
    error, as the standard output is the command's.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGUSR1, buffer.clock.interrupt)
    os.dup2(2, 1)
    threading.Thread(target=_leave_with, args=(driver,), daemon=True).start()
    _register("numba:compile", Compiling(buffer.clock))
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):  # the driver is gone
        connection.send(None)
        while True:
            job = connection.recv()
            _serve_job(job, connection, buffer)


def _leave_with(driver: int) -> None:
    while os.getppid() == driver:
        time.sleep(LOOK_EVERY)
    os._exit(1)


def _serve_job(job: Job, connection: Connection, buffer: SharedStepBuffer) -> None:
    try:
        made = _made(job, buffer.clock)
        for record in fly(made, job.policy.name, job.scenario, job.tasks, buffer, job.bounds):
            connection.send(record.without_map() if record.task in job.bounds else record)
        connection.send(None)
    except InputError as error:
        connection.send(error)
    except Exception as error:
        broken = RunError(f"an episode of {job.policy.name} cannot be flown: {describe_error(error)}")
        broken.add_note(traceback.format_exc())
        connection.send(broken)


def _made(job: Job, clock: Clock) -> Policy:
    """Make the policy of a job, or one that breaks as the making did."""
    try:
        with clock:
            return job.policy.make()
    except InputError:
        raise
    except BREAKING as error:
        return _Unmade(error=error)


@dataclass(frozen=True, kw_only=True)
class _Unmade(Policy):
    """A policy that cannot be made."""

    error: BaseException

    def pilot(self, briefing: Briefing) -> Pilot:
        raise self.error


class Compiling(_Listener):  # type: ignore[misc]  # a base class without types
    """Begin a decision's time anew after each function that numba had to compile for it: machines differ in that."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._depth = 0
        self._deciding = False

    def on_start(self, event: Any) -> None:
        """Stop the clock."""
        self._depth += 1
        if self._depth == 1:
            self._deciding = self._clock.asked > 0
            self._clock.__exit__()

    def on_end(self, event: Any) -> None:
        """Start it again."""
        self._depth -= 1
        if self._depth == 0 and self._deciding:
            self._clock.__enter__()
