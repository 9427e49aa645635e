"""Proxies for the pilots in the process of an isolated policy; its replies are validated."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from indoor_explorers.env import Briefing, InputError, View
from indoor_explorers.env.errors import LONGEST, one_line
from indoor_explorers.env.policies.policy import checked_action
from indoor_explorers.env.policies.view import message_numbers, values_of
from indoor_explorers.env.simulation.rollout import Uav
from indoor_explorers.evaluation.harness.engines.policy_handle import PolicyHandle
from indoor_explorers.evaluation.harness.episodes.pilots import (
    PREFIX,
    BatchFailed,
    Decision,
    Tallies,
    any_briefing,
    mean_tallies,
)
from indoor_explorers.evaluation.harness.experiment.experiment import Job

#: Seconds by which the decision times that a process reports may exceed the time from question to answer.
TOLERANCE = 0.01
#: Errors of reading an invalid answer.
UNEXPECTED = (TypeError, ValueError, LookupError, AttributeError, OverflowError)


class RemotePilots:
    """The pilots of an isolated policy: see :class:`~indoor_explorers.evaluation.harness.episodes.pilots.Pilots`.

    All methods raise :class:`~.policy_handle.ProcessEnded` if the process ends, or sends an invalid answer.
    """

    def __init__(self, process: PolicyHandle, job: Job) -> None:
        """Have the process make the policy of a job.

        Raises:
            InputError: it cannot be made.

        """
        self._process = process
        self._checking = _Checking(process)
        self._actions = 5
        self.privileged = job.privileged
        with self._checking:
            reply = process.load(job.policy)
            if "refused" in reply:
                raise InputError(_line(reply["refused"]))
            self._failure = _line(reply.get("failed", ""))

    def brief(self, briefings: Mapping[int, Sequence[Briefing]]) -> dict[int, str]:
        """Make the pilots of a new batch."""
        if self._failure:
            return dict.fromkeys(briefings, self._failure)
        one = any_briefing(briefings)
        self._actions = one.scenario.actions
        uavs = [(episode, agent) for episode, team in briefings.items() for agent in range(len(team))]
        self._process.views.begin(
            uavs, one.shape, writing=True, uncertain=one.scenario.uncertain, moves=one.levels.moves
        )
        with self._checking:
            failed = self._process.ask("brief", dict(briefings))
            return {_one_of(briefings, episode): _line(reason) for episode, reason in failed}

    def decide(self, views: Mapping[Uav, View]) -> dict[Uav, Decision]:
        """Ask for the decisions of all UAVs in one message; the process asks an unbatched policy UAV by UAV."""
        shown = []
        for uav, view in views.items():
            self._process.views.write(uav, view)
            shown.append((uav, values_of(view)))
        if not shown:
            return {}
        with self._checking:
            answers = self._process.ask("decide", shown)
            if answers is None and len({episode for episode, _ in views}) > 1:
                raise BatchFailed
            pairs = zip(views, answers, strict=True)
            decided = {uav: _decision(self._actions, *answer) for uav, answer in pairs if answer is not None}
            reported, measured = sum(each.seconds for each in decided.values()), self._process.seconds
            if reported > measured + TOLERANCE:
                raise ValueError(f"expected decisions of at most {measured:.3g} s, got {reported:.3g} s")
            return decided

    def tally(self, episodes: Collection[int]) -> dict[int, Tallies | str]:
        """Return the statistics of episodes that have ended, or the reason of a failure."""
        if self._failure:
            return {}
        with self._checking:
            reply = self._process.ask("tally", list(episodes))
            return {_one_of(episodes, episode): _tallies(tallies) for episode, tallies in reply}

    def close(self) -> None:
        """Have the policy deleted."""
        self._process.ask("unload")


class _Checking:
    """Ends the process if an answer is invalid; quicker than a generator, which would dominate the time here."""

    def __init__(self, process: PolicyHandle) -> None:
        self._process = process

    def __enter__(self) -> None:
        """Begin to check."""

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, UNEXPECTED) and not isinstance(error, InputError):
            raise self._process.unreadable() from error


def _one_of(episodes: Collection[int], episode: Any) -> int:
    if episode not in episodes:
        raise ValueError(f"expected one of {len(episodes)} episodes, got {episode!r}")
    return int(episode)


def _line(text: str) -> str:
    return one_line(text, 3 * LONGEST)


def _decision(
    actions: int, seconds: float, action: object, message: Any, failure: str, done: object = False
) -> Decision:
    if failure:
        return Decision(0.0, failure=_line(failure))
    if not 0.0 <= seconds < math.inf:
        raise ValueError(f"expected the seconds of a decision, got {seconds!r}")
    try:
        return Decision(float(seconds), checked_action(action, actions), message_numbers(message), done=done is True)
    except InputError as error:
        raise ValueError(str(error)) from error


def _tallies(reply: Any) -> Tallies | str:
    """Return statistics, or why they cannot be used."""
    if isinstance(reply, str):
        return _line(reply)
    try:
        return mean_tallies([{name.removeprefix(PREFIX): value for name, value in reply.items()}])
    except InputError as error:
        return str(error)
