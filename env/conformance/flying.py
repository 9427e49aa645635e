"""Fly checked episodes: every call of the policy is guarded, and every answer is checked and recorded.

A wrong action is recorded and replaced by a stay, a wrong message by None, so one fault fails one check alone. An error
of the policy, or a change of a read-only array, ends the flight.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from indoor_explorers.env.conformance.findings import CannotFly, calling, shown
from indoor_explorers.env.conformance.traces import (
    Decision,
    Setup,
    Trace,
    action_of,
    check_briefed,
    check_explained,
    check_tallied,
    checked_message,
    digest_of,
    facts_of,
)
from indoor_explorers.env.grid.arrays import Belief, read_only
from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.sources import MapSource
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.rollout import Uav, rollout
from indoor_explorers.env.simulation.world import World


def together(asked: list[Uav]) -> list[list[Uav]]:
    """Ask all UAVs in one call, as the harness does."""
    return [asked]


def backwards(asked: list[Uav]) -> list[list[Uav]]:
    """Ask all UAVs in one call, the last one first."""
    return [asked[::-1]]


def one_by_one(asked: list[Uav]) -> list[list[Uav]]:
    """Ask each UAV in a call of its own."""
    return [[one] for one in asked]


def is_privileged(policy: Policy) -> bool:
    """Tell whether a policy asks for the true map."""
    with calling("policy.privileged"):
        return bool(policy.privileged)


class Changed(NamedTuple):
    """A UAV whose actions are replaced."""

    agent: int
    wanders: bool
    """True: it is asked as before but makes random legal moves. False: it is not asked, stays and sends nothing."""


class Misled(NamedTuple):
    """A UAV whose view contains unseen cells of the true map, and that repeats its earlier actions and messages."""

    agent: int
    before: Trace
    """The same episode with the UAV's own views."""

    def view(self, view: View, truth: Belief) -> View:
        """Return its view with the unseen cells of the true map, except for the rows that are farthest from it."""
        rows = np.arange(len(truth))[:, None]
        far = abs(rows - view.cell[0]) > 0.8 * abs(rows - view.cell[0]).max()
        shown = np.where((view.belief == UNKNOWN) & ~far, truth, view.belief)
        added = np.where(shown == OCCUPIED, 5.0, -5.0) * (shown != view.belief)
        log_odds = None if view.log_odds is None else read_only((view.log_odds + added).astype(np.float32))
        return view._replace(belief=read_only(shown), log_odds=log_odds)


class CheckedFlight:
    """Fly one policy in a batch of episodes side by side."""

    def __init__(
        self,
        policy: Policy,
        scenario: Scenario,
        setups: Sequence[Setup],
        *,
        ask: Callable[[list[Uav]], list[list[Uav]]] = together,
        changed: Changed | None = None,
        told: MapSource | None = None,
        misled: Misled | None = None,
        unseen: bool = True,
        explaining: bool = False,
    ) -> None:
        """Start the episodes of ``setups``.

        Args:
            policy: The policy to check.
            scenario: The task.
            setups: Seeds, maps, spawns and prior maps, one for each episode.
            ask: Divides the UAVs to be asked into calls.
            changed: A UAV whose actions are replaced.
            told: A false source of maps for the briefings.
            misled: A UAV whose views are replaced.
            unseen: Whether the traces have the cells that no UAV has seen, an array for each step.
            explaining: Whether each pilot is asked after each action to explain it.

        """
        self._policy = policy
        self._ask = ask
        self._changed, self._misled, self._unseen = changed, misled, unseen
        self._explaining = explaining
        self.explained = 0
        """Actions that pilots have explained."""
        self._task = scenario.model_copy(deep=True)  # which the policy may reach through its briefing
        self._told = None if told is None else self._task.model_copy(update={"map": told})
        self._world = World(self._task, len(setups))
        for b, setup in enumerate(setups):
            self._world.begin(b, setup.seed, floorplan=setup.floorplan, spawns=setup.spawns)
        self.traces = [Trace(setup) for setup in setups]
        """What was flown so far, also after an error."""
        self._rngs = [np.random.default_rng(setup.seed) for setup in setups]
        self._briefings: list[tuple[Trace, Briefing, dict[str, str]]] = []
        """The briefing of each pilot, and its facts at the start."""
        self._pilots = {
            (b, n): self._pilot(trace, b, n) for b, trace in enumerate(self.traces) for n in range(scenario.team)
        }

    @property
    def pilot_kind(self) -> type[Pilot]:
        """The class of the policy's pilots."""
        return type(self._pilots[0, 0])

    def _pilot(self, trace: Trace, b: int, n: int) -> Pilot:
        briefing = self._world.briefing(b, n, privileged=is_privileged(self._policy))
        if self._told is not None:
            briefing = replace(briefing, scenario=self._told)
        if trace.setup.prior is not None:
            briefing = replace(briefing, prior=trace.setup.prior)
        self._briefings.append((trace, briefing, facts_of(briefing)))
        with calling("policy.pilot"):
            pilot = self._policy.pilot(briefing)
        if not isinstance(pilot, Pilot):
            raise CannotFly(f"expected policy.pilot to return a Pilot, got {shown(pilot)}", "subclass Pilot")
        if self._explaining:
            pilot.explaining = True
        return pilot

    @property
    def world(self) -> World:
        """The world, for reading."""
        return self._world

    def fly(self, steps: int, until: Callable[[World], bool] | None = None) -> list[Trace]:
        """Fly at most ``steps`` steps, or until the world is as asked, and return the trace of each episode.

        Raises:
            CannotFly: the policy raises, answers for another number of UAVs, or changes a view.

        """
        for _ in islice(rollout(self._world, self._decided), steps):
            if until is not None and until(self._world):
                break
        self._debrief()
        return self.traces

    def _decided(self, flying: list[Uav]) -> Iterator[tuple[Uav, int]]:
        """Ask the UAVs in turn; a wandering one's answer is replaced."""
        for b in sorted({b for b, _ in flying}):
            self.traces[b].steps.append({})
            if self._unseen:
                self.traces[b].unseen.append((self._world.state.union[b] == UNKNOWN).tobytes())
        present = [(b, n) for b, n in flying if self._changed != Changed(n, wanders=False)]
        for group in filter(None, self._ask(present)):
            yield from zip(group, self._answers(group), strict=True)
        for b, n in flying:
            if self._changed == Changed(n, wanders=True):
                yield (b, n), int(self._rngs[b].choice(np.flatnonzero(self._world.state.legal[b, n])))

    def _answers(self, group: list[Uav]) -> list[int]:
        """Ask some UAVs in one call and record their choices."""
        state = self._world.state
        pilots, views = [self._pilots[one] for one in group], [self._world.view(b, n) for b, n in group]
        digests = [digest_of(view) for view in views]
        if self._misled is not None:
            pairs = zip(group, views, strict=True)
            views = [self._misled.view(v, state.truth[b]) if n == self._misled.agent else v for (b, n), v in pairs]
        guarded = (state.belief, state.legal, state.visited, state.truth)
        before = [array.copy() for array in guarded]
        with calling("act"):
            start = time.perf_counter()
            answers: Any = self._policy.act(pilots, views)
            share = (time.perf_counter() - start) / len(group)
            chosen = list(answers) if isinstance(answers, Collection) else None
        if not all(np.array_equal(old, new) for old, new in zip(before, guarded, strict=True)):
            raise CannotFly("act changed the view it was given", "views are live, copy what you write to")
        if chosen is None or len(chosen) != len(group):
            got = shown(answers) if chosen is None else f"{len(chosen)}: {shown(answers)}"
            raise CannotFly(f"expected a list of {len(group)} actions from act, got {got}", "return one for each pilot")
        return [
            self._recorded(b, n, action, digest, share)
            for (b, n), action, digest in zip(group, chosen, digests, strict=True)
        ]

    def _recorded(self, b: int, n: int, answer: object, digest: bytes, share: float) -> int:
        """Record one UAV's answer and post its message; returns the action to fly."""
        trace, world = self.traces[b], self._world
        action = action_of(answer, trace, world.scenario.actions)
        with calling("pilot.message"):
            said = self._pilots[b, n].message
        message = checked_message(said, trace)
        if self._explaining:
            self._explain(self._pilots[b, n])
        if self._misled is not None and n == self._misled.agent:
            before = self._misled.before.steps[len(trace.steps) - 1].get(n)
            action, message = before.choice if before is not None else (action, message)
        trace.seconds.append(share)
        legal = world.state.legal[b, n]
        trace.into_walls += action < len(legal) and not legal[action]
        trace.steps[-1][n] = Decision(digest, action, message)
        world.post(b, n, message)
        return action

    def _explain(self, pilot: Pilot) -> None:
        with calling("pilot.explain"):
            told = pilot.explain()
        if told is not None:
            check_explained(told, self._world.state.truth.shape[1:])
            self.explained += 1

    def _debrief(self) -> None:
        """Check each pilot's tally and that the briefings are unchanged."""
        for (b, _), pilot in self._pilots.items():
            check_tallied(pilot, self.traces[b])
        for trace, briefing, facts in self._briefings:
            check_briefed(briefing, facts, trace)
