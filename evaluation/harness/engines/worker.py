"""The code of a worker process: it receives jobs, flies them and sends back the records.

Limits on time and memory are enforced by the process that started it, see
:mod:`indoor_explorers.evaluation.harness.engines.supervisor`.
"""

from __future__ import annotations

import contextlib
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection

from indoor_explorers.env import Briefing, InputError, Pilot, Policy
from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.harness.engines.compiling import compile_world
from indoor_explorers.evaluation.harness.engines.keeper import MOST_PROCESSES
from indoor_explorers.evaluation.harness.engines.policy_handle import PolicyHost, ProcessEnded
from indoor_explorers.evaluation.harness.engines.remote_pilots import RemotePilots
from indoor_explorers.evaluation.harness.engines.serving import begin_serving
from indoor_explorers.evaluation.harness.episodes.failures import BREAKING, describe_error
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock, SharedStepBuffer
from indoor_explorers.evaluation.harness.experiment.experiment import Job
from indoor_explorers.evaluation.harness.experiment.limits import Limits


def serve(connection: Connection, buffer: SharedStepBuffer, driver: int, limits: Limits) -> None:
    """Serve until the connection closes: of a job send every record, then None, or the exception that ended it.

    A policy that is to be isolated flies in a process of its own, to which ``limits`` apply; where that process ends,
    its :class:`~.process_handle.ProcessExit` is sent.
    """
    begin_serving(buffer.clock, connection, driver, most=2 * MOST_PROCESSES)
    host = PolicyHost(limits)
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):  # the driver has ended
        connection.send(None)
        compile_world()
        while True:
            _serve_job(connection.recv(), connection, buffer, host)
    host.discard()


def _serve_job(job: Job, connection: Connection, buffer: SharedStepBuffer, host: PolicyHost) -> None:
    try:
        for record in _isolated(job, buffer, host) if job.isolated else _here(job, buffer):
            connection.send(record.without_map() if record.task in job.bounds else record)
        connection.send(None)
    except ProcessEnded as ended:
        host.discard()
        connection.send(ended.how)
    except InputError as error:
        connection.send(error)
    except Exception as error:
        broken = RunError(f"an episode of {job.policy.name} cannot be flown: {describe_error(error)}")
        broken.add_note(traceback.format_exc())
        connection.send(broken)


def _isolated(job: Job, buffer: SharedStepBuffer, host: PolicyHost) -> Iterator[Record]:
    """Fly a job with the policy in a process that never has the world."""
    pilots = RemotePilots(host.process(job.policy), job)
    yield from fly(pilots, job.policy.name, job.scenario, job.tasks, buffer, job.bounds)
    pilots.close()


def _here(job: Job, buffer: SharedStepBuffer) -> Iterator[Record]:
    """Fly a job with the policy in this process; what it does when it is deleted counts as its time."""
    policy = _make_policy(job, buffer.clock)
    yield from fly(policy, job.policy.name, job.scenario, job.tasks, buffer, job.bounds)
    with buffer.clock:
        del policy


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
