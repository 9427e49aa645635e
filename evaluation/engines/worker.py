"""The code of a worker process: it receives jobs, flies them and sends back the records.

Limits on time and memory are enforced by the process that started it, see
:mod:`indoor_explorers.evaluation.engines.worker_handle`.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import threading
import time
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from numba.core import event

from indoor_explorers.env import Briefing, InputError, Pilot, Policy, make_policy
from indoor_explorers.env.errors import PolicyError, RunError
from indoor_explorers.evaluation.episodes.failures import BREAKING, describe_error
from indoor_explorers.evaluation.episodes.runner import fly
from indoor_explorers.evaluation.episodes.shared_clock import Clock, DecisionTimeout
from indoor_explorers.evaluation.episodes.shared_steps import SharedStepBuffer
from indoor_explorers.evaluation.experiment.experiment import Job, PolicyChoice
from indoor_explorers.evaluation.experiment.policy_facts import policy_facts

#: Seconds between two checks that the driver is still running.
CHECK_INTERVAL = 0.5
#: What is timed when a policy is loaded.
LOADING = "importing and making it"
#: numba has no types for its events.
_Listener: Any = event.Listener
_register: Any = event.register


class KnowledgeCheck(NamedTuple):
    """Asks for the check for hidden knowledge that a policy fails."""

    policy: PolicyChoice


def serve(connection: Connection, buffer: SharedStepBuffer, driver: int) -> None:
    """Serve until the connection closes: of a job send every record, then None; of a policy its facts as JSON.

    An exception is sent where that fails.

    Of a :class:`KnowledgeCheck` send the check that the policy fails, empty for none, or None if it cannot be checked.

    Ctrl-C is handled by the driver; when the driver is killed, this process exits. What policies print goes to the
    standard error, as the standard output belongs to the command.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGUSR1, buffer.clock.interrupt)
    os.dup2(2, 1)
    threading.Thread(target=_exit_with, args=(driver,), daemon=True).start()
    _register("numba:compile", Compiling(buffer.clock))
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):  # the driver is gone
        connection.send(None)
        while True:
            asked = connection.recv()
            if isinstance(asked, Job):
                _serve_job(asked, connection, buffer)
            elif isinstance(asked, KnowledgeCheck):
                _serve_check(asked.policy, connection, buffer.clock)
            else:
                _serve_facts(asked, connection, buffer.clock)


def _exit_with(driver: int) -> None:
    while os.getppid() == driver:
        time.sleep(CHECK_INTERVAL)
    os._exit(1)


def _serve_job(job: Job, connection: Connection, buffer: SharedStepBuffer) -> None:
    try:
        policy = _make_policy(job, buffer.clock)
        for record in fly(policy, job.policy.name, job.scenario, job.tasks, buffer, job.bounds):
            connection.send(record.without_map() if record.task in job.bounds else record)
        with buffer.clock:
            del policy  # what it does when it is deleted counts as its time
        connection.send(None)
    except InputError as error:
        connection.send(error)
    except Exception as error:
        broken = RunError(f"an episode of {job.policy.name} cannot be flown: {describe_error(error)}")
        broken.add_note(traceback.format_exc())
        connection.send(broken)


def _serve_facts(choice: PolicyChoice, connection: Connection, clock: Clock) -> None:
    """Make a policy and send its facts, or an :class:`InputError` that says in one line why that fails."""
    try:
        with clock:
            policy = choice.make()
            answer: str | InputError = json.dumps(policy_facts(policy, choice.use))
    except BaseException as error:
        answer = InputError(_not_loaded(choice, error))
    connection.send(answer)
    threading.Event().wait()  # the policy is not deleted here: the driver ends the process


def _not_loaded(choice: PolicyChoice, error: BaseException) -> str:
    """Say in one line why a policy cannot be loaded, and where in its code."""
    text = describe_error(error)
    if isinstance(error, DecisionTimeout):
        return f"policy {choice.name!r}: {text.replace('decision', LOADING, 1)}"
    if not isinstance(error, (InputError, PolicyError)):
        return f"policy {choice.name!r} cannot be loaded: {text}; correct it or leave it out"
    text = text.removeprefix(f"{type(error).__name__}: ")
    return text if repr(choice.use) in text else f"policy {choice.name!r}: {text}"


def _serve_check(choice: PolicyChoice, connection: Connection, clock: Clock) -> None:
    """Check a policy as one decision, before which the world has been compiled."""
    from indoor_explorers.env.conformance import failed_check

    failed_check(make_policy("random"))
    answer = None
    with contextlib.suppress(BaseException), clock:
        policy = choice.make()
        answer = failed_check(policy)
    connection.send(answer)
    threading.Event().wait()  # the policy is not deleted here: the driver ends the process


def _make_policy(job: Job, clock: Clock) -> Policy:
    """Make the policy of a job; where that fails, return one whose pilots raise the same error."""
    try:
        with clock:
            return job.policy.make()
    except InputError:
        raise
    except BREAKING as error:
        return _FailedPolicy(error=error)


@dataclass(frozen=True, kw_only=True)
class _FailedPolicy(Policy):
    """Stands for a policy whose constructor failed, so that its episodes fail with that error."""

    error: BaseException

    def pilot(self, briefing: Briefing) -> Pilot:
        raise self.error


class Compiling(_Listener):  # type: ignore[misc]  # a base class without types
    """Restart the clock of a decision after each function that numba compiled for it: compiling does not count."""

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
