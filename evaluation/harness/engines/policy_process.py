"""The process of an isolated policy: it never has the world, only questions and the views of its UAVs.

It answers in JSON, so that the other process never runs code from a policy, as unpickling could.
"""

from __future__ import annotations

import contextlib
import json
import os
import pickle
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from multiprocessing.connection import Connection
from typing import Any

from indoor_explorers.env import Briefing, InputError, Policy
from indoor_explorers.env.errors import PolicyError
from indoor_explorers.env.grid.arrays import read_only
from indoor_explorers.env.policies.view import view_of
from indoor_explorers.env.simulation.rollout import Uav
from indoor_explorers.evaluation.harness.engines.serving import begin_serving
from indoor_explorers.evaluation.harness.episodes.failures import BREAKING, describe_error
from indoor_explorers.evaluation.harness.episodes.pilots import (
    BatchFailed,
    Decision,
    LocalPilots,
    Tallies,
    any_briefing,
)
from indoor_explorers.evaluation.harness.episodes.shared_memory import DecisionTimeout, SharedViews
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts

#: Stands for "decision" in the message about a policy that takes too long to load.
LOADING = "importing and making it"


def serve_policy(connection: Connection, views: SharedViews, parent: int) -> None:
    """Answer questions until the connection closes; the first answer says that this process has started.

    A question is the name of a method of :class:`PolicyServer` and its arguments. The process exits with its parent.
    """
    begin_serving(views.clock, connection, parent)
    server = PolicyServer(views)
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        connection.send_bytes(b"null")
        while True:
            name, *arguments = pickle.loads(connection.recv_bytes())
            connection.send_bytes(json.dumps(getattr(server, name)(*arguments)).encode())
    os._exit(1)


class PolicyServer:
    """Holds one policy and its pilots; every method returns a value that JSON can represent."""

    def __init__(self, views: SharedViews) -> None:
        self._views, self._clock = views, views.clock
        self._policy: Policy | None = None
        self._pilots: LocalPilots | None = None

    def facts(self, choice: PolicyChoice) -> dict[str, Any]:
        """Make a policy and return its facts, or why it is refused; it is not deleted as long as this process runs."""
        try:
            with self._clock:
                self._policy = choice.make()
                facts = policy_facts(self._policy, choice.use)
        except BaseException as error:
            return {"refused": _not_loaded(choice, error)}
        return {"facts": facts}

    def load(self, choice: PolicyChoice) -> dict[str, str]:
        """Make a policy; return why it is refused, or why it failed; empty on success."""
        try:
            with self._clock:
                self._pilots = LocalPilots(choice.make(), self._clock)
        except InputError as error:
            return {"refused": str(error)}
        except BREAKING as error:
            return {"failed": describe_error(error)}
        return {}

    def unload(self) -> None:
        """Delete the policy; what it does then counts as a decision's time."""
        with contextlib.suppress(*BREAKING), self._clock:
            self._pilots = None

    def brief(self, briefings: Mapping[int, Sequence[Briefing]]) -> list[tuple[int, str]]:
        """Make the pilots of a new batch; return the episodes that failed, with the reason."""
        assert self._pilots is not None
        one = any_briefing(briefings)
        uavs = [(episode, n) for episode, team in briefings.items() for n in range(len(team))]
        self._views.begin(uavs, one.shape, uncertain=one.scenario.uncertain, moves=one.levels.moves)
        mine = {episode: [_sealed(briefing) for briefing in team] for episode, team in briefings.items()}
        return list(self._pilots.brief(mine).items())

    def decide(self, shown: Sequence[tuple[Uav, tuple[Any, ...]]]) -> list[Decision | None] | None:
        """Return the decisions of some UAVs in order, None for one that is left out; None alone if the batch failed.

        ``shown``: the UAVs whose arrays are in the shared memory, with the other fields of their views (``values_of``).
        """
        assert self._pilots is not None
        arrays = self._views.arrays
        try:
            decided = self._pilots.decide({uav: view_of(arrays[uav], values) for uav, values in shown})
        except BatchFailed:
            return None
        return [decided.get(uav) for uav, _ in shown]

    def tally(self, episodes: Collection[int]) -> list[tuple[int, Tallies | str]]:
        """Return the statistics of episodes that have ended, or the reason of a failure."""
        assert self._pilots is not None
        return list(self._pilots.tally(episodes).items())


def _not_loaded(choice: PolicyChoice, error: BaseException) -> str:
    """Say in one line why a policy cannot be loaded, with the place in its code."""
    text = describe_error(error)
    if isinstance(error, DecisionTimeout):
        return f"policy {choice.name!r}: {text.replace('decision', LOADING, 1)}"
    if not isinstance(error, (InputError, PolicyError)):
        return f"policy {choice.name!r} cannot be loaded: {text}; correct it or leave it out"
    text = text.removeprefix(f"{type(error).__name__}: ")
    return text if repr(choice.use) in text else f"policy {choice.name!r}: {text}"


def _sealed(briefing: Briefing) -> Briefing:
    """Return a briefing whose maps cannot be written to."""
    truth, prior = (None if cells is None else read_only(cells) for cells in (briefing.truth, briefing.prior))
    return replace(briefing, truth=truth, prior=prior)
