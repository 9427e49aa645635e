"""A policy whose pilots are in another process, so that the conformance checks are flown by this one."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, cast

from indoor_explorers.env import Briefing, Pilot, Policy, View
from indoor_explorers.env.errors import PolicyError
from indoor_explorers.env.simulation.rollout import Uav
from indoor_explorers.evaluation.harness.engines.policy_handle import PolicyHandle, ProcessEnded
from indoor_explorers.evaluation.harness.engines.process_handle import ProcessExit
from indoor_explorers.evaluation.harness.engines.remote_pilots import RemotePilots
from indoor_explorers.evaluation.harness.episodes.record import is_of_machine
from indoor_explorers.evaluation.harness.experiment.experiment import Job

#: Seconds that the last decision may take at least.
LEAST = 0.1


class RemotePolicy(Policy):
    """Proxy of an isolated policy; fly one batch of episodes after the other.

    The time limit of its process holds for all decisions together; a policy that takes longer is killed.
    """

    def __init__(self, process: PolicyHandle, job: Job, facts: Mapping[str, Any]) -> None:
        """Have the process make the policy of a job.

        Raises:
            InputError: it cannot be made.
            PolicyError: no time is left.
            ProcessEnded: its process ended, or had to be killed.

        """
        # variables of the class in other policies
        vars(self).update({name: facts.get(name) for name in ("batched", "uses_generator", "map_shape")})
        self.seconds_left = process.limits.decision_timeout or math.inf
        self.ended: ProcessExit | None = None
        """How its process ended or was killed; None while it runs."""
        self._process = process
        self._batch = _Briefings()
        with self._timed():
            self._remote = RemotePilots(process, job)

    @property
    def killed(self) -> bool:
        """Whether the machine may have ended its process."""
        return self.ended is not None and is_of_machine(self.ended.reason)

    @property
    def unjudged(self) -> bool:
        """Whether it took too long, or the machine may have ended its process, so that no verdict is possible."""
        return self.seconds_left < 0 or self.killed

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV; all pilots of a batch are briefed together at the first decision."""
        if self._batch.begun:
            self._batch = _Briefings()
        return RemotePilot(self, self._batch.add(briefing))

    def act(self, pilots: Sequence[Pilot], views: Sequence[View]) -> list[int]:
        """Return the actions of one UAV of the batch, or of many if the policy is batched.

        Raises:
            PolicyError: the policy failed there, or no time is left.
            ProcessEnded: its process ended, or had to be killed.

        """
        mine = cast(Sequence[RemotePilot], pilots)
        with self._timed():
            if not self._batch.begun:
                self._batch.begun = True
                for failure in self._remote.brief(self._batch.briefings).values():
                    raise PolicyError(failure)
            decided = self._remote.decide({pilot.uav: view for pilot, view in zip(mine, views, strict=True)})
        for failure in (decision.failure for decision in decided.values() if decision.failure):
            raise PolicyError(failure)
        for pilot in mine:
            pilot.message = decided[pilot.uav].message
        return [decided[pilot.uav].action for pilot in mine]

    @contextmanager
    def _timed(self) -> Iterator[None]:
        """Limit the process to the remaining time, and subtract the time of the block from it."""
        begun = time.monotonic()
        self._process.limits = self._process.limits._replace(decision_timeout=max(self.seconds_left, LEAST))
        try:
            yield
        except ProcessEnded as ended:
            self.ended = ended.how
            raise
        finally:
            self.seconds_left -= time.monotonic() - begun
        if self.seconds_left < 0:
            raise PolicyError("no time is left")


class RemotePilot(Pilot):
    """Proxy of a pilot in another process; ``uav`` is its episode and its number in the batch."""

    def __init__(self, policy: RemotePolicy, uav: Uav) -> None:
        self._policy, self.uav = policy, uav

    def act(self, view: View) -> int:
        """Ask its process alone."""
        (action,) = self._policy.act([self], [view])
        return action


class _Briefings:
    """The briefings of a batch, which are given episode by episode, UAV by UAV."""

    def __init__(self) -> None:
        self.briefings: dict[int, list[Briefing]] = {}
        self.begun = False

    def add(self, briefing: Briefing) -> Uav:
        """Add a briefing; return the UAV that it is for."""
        episode = len(self.briefings) - (briefing.agent > 0)
        self.briefings.setdefault(episode, []).append(briefing)
        return episode, briefing.agent
