"""The pilots of a batch of episodes, and their decisions with the seconds that each took."""

from __future__ import annotations

import contextlib
import math
import numbers
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from indoor_explorers.env import Briefing, InputError, Pilot, Policy, View
from indoor_explorers.env.errors import one_line
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.policy import checked_action
from indoor_explorers.env.policies.view import Message, message_numbers
from indoor_explorers.env.simulation.rollout import Uav
from indoor_explorers.evaluation.harness.episodes.failures import BREAKING, describe_error
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock
from indoor_explorers.evaluation.harness.episodes.thinking_time import thinking_time

#: Limits of a tally: names, and characters of a name.
MOST_NAMES, LONGEST_NAME = 64, 64
#: What the names of these statistics begin with in records.
PREFIX = "pilot_"


def mean_tallies(tallies: Sequence[object]) -> dict[str, float | None]:
    """Return the means of the UAVs' tallies by name, with the prefix of records.

    Raises:
        InputError: one is not a dict of finite numbers by short names, or there are too many names.

    """
    checked = [_checked(tally) for tally in tallies]
    names = sorted({name for tally in checked for name in tally})
    if len(names) > MOST_NAMES:
        raise InputError(f"expected at most {MOST_NAMES} names in the tallies of a team, got {len(names)}")
    return {PREFIX + name: float(np.mean([tally[name] for tally in checked if name in tally])) for name in names}


def _checked(tally: object) -> dict[str, float]:
    if not isinstance(tally, Mapping):
        raise InputError(f"expected tally() to return a dict, got {type(tally).__name__}")
    if len(tally) > MOST_NAMES:
        raise InputError(f"expected at most {MOST_NAMES} names in a tally, got {len(tally)}")
    return dict(_entry(name, value) for name, value in tally.items())


def _entry(name: object, value: object) -> tuple[str, float]:
    if not isinstance(name, str) or not name.isprintable() or not 0 < len(name) <= LONGEST_NAME:
        shown = one_line(repr(name), LONGEST_NAME)
        raise InputError(f"expected names of a tally to be texts of 1 to {LONGEST_NAME} characters, got {shown}")
    if not isinstance(value, numbers.Real) or not math.isfinite(number := float(value)):
        raise InputError(f"expected tally {name!r} to be a finite number, got {one_line(repr(value), LONGEST_NAME)}")
    return str(name), number


#: The statistics of an episode by name.
Tallies = dict[str, float | None]


class BatchFailed(Exception):
    """A policy failed while it decided for several episodes at once."""


class Decision(NamedTuple):
    """The decision of one UAV."""

    seconds: float
    action: int = int(Action.STAY)
    message: Message = None
    failure: str = ""
    """Why there is none; empty if there is one."""
    done: bool = False
    """Whether the UAV would end its mission now."""


class Pilots(Protocol):
    """The pilots of a batch, in any process; an exception of the policy becomes the reason of a failure."""

    @property
    def privileged(self) -> bool:
        """Whether they receive the ground truth."""

    def brief(self, briefings: Mapping[int, Sequence[Briefing]]) -> dict[int, str]:
        """Make the pilots of a new batch, given the briefings of each episode; return reasons of failures."""

    def decide(self, views: Mapping[Uav, View]) -> Mapping[Uav, Decision]:
        """Return the decisions of some UAVs; those of an episode are left out after the first one that failed.

        Raises:
            BatchFailed: the policy failed, and it is not known in which episode.

        """

    def tally(self, episodes: Collection[int]) -> dict[int, Tallies | str]:
        """Return the statistics of episodes that have ended, or the reason of a failure, and delete all pilots."""


class LocalPilots:
    """Pilots in the process of their policy, each of whose calls the clock times: see :class:`Pilots`."""

    def __init__(self, policy: Policy, clock: Clock) -> None:
        self._policy, self._clock = policy, clock
        self._pilots: dict[int, list[Pilot]] = {}
        self._actions = 5

    @property
    def privileged(self) -> bool:
        """Whether they receive the ground truth."""
        return self._policy.privileged

    def brief(self, briefings: Mapping[int, Sequence[Briefing]]) -> dict[int, str]:
        """Make the pilots of a new batch."""
        self.forget()
        failures = {}
        self._actions = any_briefing(briefings).scenario.actions
        for episode, team in briefings.items():
            try:
                with self._clock:
                    self._pilots[episode] = [self._policy.pilot(briefing) for briefing in team]
            except BREAKING as error:
                failures[episode] = describe_error(error)
        return failures

    def decide(self, views: Mapping[Uav, View]) -> dict[Uav, Decision]:
        """Ask one UAV after the other, or all at once where the policy is batched."""
        decided: dict[Uav, Decision] = {}
        failed: set[int] = set()
        for group in [list(views)] if self._policy.batched else [[uav] for uav in views]:
            if group and group[0][0] not in failed:
                for uav, decision in self._decide(group, [views[uav] for uav in group]):
                    decided[uav] = decision
                    if decision.failure:
                        failed.add(uav[0])
        return decided

    def tally(self, episodes: Collection[int]) -> dict[int, Tallies | str]:
        """Ask for statistics, and delete all pilots while the clock runs."""
        found: dict[int, Tallies | str] = {}
        for episode in episodes:
            try:
                with self._clock:
                    found[episode] = mean_tallies([pilot.tally() for pilot in self._pilots[episode]])
                    del self._pilots[episode]
            except BREAKING as error:
                found[episode] = describe_error(error)
        self.forget()
        return found

    def forget(self) -> None:
        """Delete the pilots; what they do then counts as a decision's time."""
        with contextlib.suppress(*BREAKING), self._clock:
            self._pilots.clear()

    def _decide(self, group: Sequence[Uav], views: Sequence[View]) -> list[tuple[Uav, Decision]]:
        """Ask some UAVs in one call."""
        pilots = [self._pilots[episode][agent] for episode, agent in group]
        try:
            with self._clock:
                start = thinking_time()
                answers = list(self._policy.act(pilots, views))
                share = (thinking_time() - start) / len(group)
                if len(answers) != len(group):
                    raise ValueError(f"act returned {len(answers)} actions for {len(group)} pilots")
                decisions = [_decision(*each, share, self._actions) for each in zip(answers, pilots, strict=True)]
        except BREAKING as error:
            if len({episode for episode, _ in group}) > 1:
                raise BatchFailed from error
            return [(group[0], Decision(0.0, failure=describe_error(error)))]
        return list(zip(group, decisions, strict=True))


def any_briefing(briefings: Mapping[int, Sequence[Briefing]]) -> Briefing:
    """Return one briefing of a batch, whose episodes share the scenario and the shape of the map."""
    return next(briefing for team in briefings.values() for briefing in team)


def _decision(answer: object, pilot: Pilot, seconds: float, actions: int) -> Decision:
    """Return the decision of a pilot as plain, immutable numbers."""
    try:
        return Decision(seconds, checked_action(answer, actions), message_numbers(pilot.message), done=bool(pilot.done))
    except (Exception, SystemExit) as error:
        return Decision(seconds, failure=describe_error(error))
