"""Failure modes that users of team explorers report, as small scenarios that a policy should finish.

In each, one UAV starts late, stops, stands in the way, is restarted or is not heard, or there is nothing to see; its
pilot is wrapped. ``evaluation/site/pages/failure-modes.md`` names the reports.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from indoor_explorers.env.conformance.findings import CannotFly, Violation, Warned
from indoor_explorers.env.conformance.flying import CheckedFlight, is_privileged
from indoor_explorers.env.conformance.harness import FIRST, SOLO, Harness
from indoor_explorers.env.conformance.traces import Setup, Trace
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import FREE, Action
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, Message, View
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.search.connected_parts import connected_parts
from indoor_explorers.env.simulation.world import World

#: Steps in which a mode has to be finished, and the share of the reachable cells that each UAV then knows.
BUDGET, FINISHED = 500, 0.99
#: The size of the maps; larger ones have walls around the drawing.
SHAPE = (16, 16)
#: A slower decision is reported, in seconds.
SLOW = 1.0
#: The rules of the episodes; every UAV has to know all.
RULES = {"on_collision": "block", "goal_of": "every", "budget": BUDGET}
#: The UAV that is faulty.
FAULTY = 1

_ROOMS = """
################
#01....#.......#
#2..#..#..#....#
#...#.....#....#
#......#.......#
#......#..#....#
###.#######.####
#......#.......#
#..#...#...#...#
#..#...#...#...#
#..............#
####.#####.#####
#..............#
#...##...##....#
#..............#
################"""
_TWO_CORRIDORS = """
################
#0...######....#
#1......+......#
#....######....#
#.##.######.##.#
#....######....#
#.......+......#
#....######....#
################"""
_ONE_DOORWAY = """
################
#.....#....#...#
#..#..#..#.#...#
#0.#..1..#.....#
#.....#....#...#
#.....#....#...#
################"""
_TWO_DOORWAYS = "".join([*_ONE_DOORWAY.splitlines(True)[:-2], "#..........#...#\n################"])
_POCKET = """
################
#0.........1.###
#...........####
################"""
_ENCLOSED = """
################
#0.#.....#.....#
####.##..#..##.#
#1...##.....##.#
#........#.....#
################"""
_BLOCKS = """
################
#0......##.....#
#..##...##.....#
#..##.......##.#
#1..........##.#
################"""


@dataclass(frozen=True, kw_only=True)
class FailureMode:
    """One scenario; UAV :data:`FAULTY` has the fault."""

    name: str
    drawing: str
    """Rows of the map: # wall, . free, + free but UAV 1 stops there for good, a digit where that UAV starts."""
    lidar: float = 3.0
    """Range in cells."""
    radio: str = "unlimited"
    """The radio model that ``check`` flies."""
    asked_from: int = 0
    """Step from which the faulty UAV's pilot is asked; before it, it stays and sends nothing."""
    restarted_at: int | None = None
    """Step at which a new pilot takes over the faulty UAV, which keeps its map."""
    mute: bool = False
    """Whether the faulty UAV's messages are lost; its map and position are still exchanged."""

    @cached_property
    def rows(self) -> np.ndarray:
        """(H, W) characters of the drawing."""
        return np.array([list(row) for row in self.drawing.split()])

    def cells(self, mark: str) -> list[Cell]:
        """Return the cells with a mark."""
        return [(row, col) for row, col in np.argwhere(self.rows == mark).tolist()]

    @property
    def spawns(self) -> tuple[Cell, ...]:
        """The starts of the UAVs, by number."""
        return tuple(cell for agent in "0123" for cell in self.cells(agent))

    def floorplan(self, shape: tuple[int, int]) -> Floorplan:
        """Return the map, with walls below and to the right of the drawing up to an (H, W) of ``shape``."""
        free = np.zeros(shape, np.bool_)
        free[: self.rows.shape[0], : self.rows.shape[1]] = self.rows != "#"
        return Floorplan.from_free(free, self.name)

    def scenario(self, shape: tuple[int, int], radio: Mapping[str, Any]) -> Scenario:
        """Return the task, that of the other checks but for the map, with some settings of the radio."""
        task = {"name": self.name, "team": len(self.spawns), "lidar.range": self.lidar, "radio.model": self.radio}
        task |= {"map.height": shape[0], "map.width": shape[1]}
        return SOLO.with_settings(task | RULES | dict(radio))

    def has_stopped(self, cell: Cell) -> bool:
        """Tell whether the faulty UAV stays in this cell to the end."""
        return self.asked_from >= BUDGET or cell in self.cells("+")


FAILURE_MODES: tuple[FailureMode, ...] = (
    FailureMode(name="late-starter", drawing=_ROOMS, lidar=2.0, asked_from=150),
    FailureMode(name="stalled-mate", drawing=_TWO_CORRIDORS, lidar=2.0),
    FailureMode(name="mate-in-doorway", drawing=_ONE_DOORWAY, lidar=2.0, asked_from=60),
    FailureMode(name="mate-in-doorway-for-good", drawing=_TWO_DOORWAYS, lidar=2.0, asked_from=BUDGET),
    FailureMode(name="mate-on-goal", drawing=_POCKET, lidar=1.0, radio="none", asked_from=60),
    FailureMode(name="empty-views", drawing=_ENCLOSED),
    FailureMode(name="short-sight", drawing=_BLOCKS, lidar=1.0),
    FailureMode(name="restarted-mate", drawing=_ROOMS, lidar=2.0, restarted_at=15),
    FailureMode(name="mute-mate", drawing=_ROOMS, lidar=2.0, mute=True),
)


class FaultyPilot(Pilot):
    """Fly as a policy's own pilot, but with a mode's fault."""

    def __init__(self, policy: Policy, briefing: Briefing, mode: FailureMode) -> None:
        self._policy, self._briefing, self._mode = policy, briefing, mode
        self._pilot = policy.pilot(briefing)

    @property
    def message(self) -> Message:  # type: ignore[override]  # a pilot's message is an attribute; this one is passed on
        """The message of the policy's own pilot, unless it is lost."""
        return None if self._mode.mute else self._pilot.message

    def act(self, view: View) -> int:
        """Stay while not started; ask the policy; stay in a cell in which the UAV stops."""
        if view.step < self._mode.asked_from:
            return int(Action.STAY)
        if view.step == self._mode.restarted_at:
            self._pilot = self._policy.pilot(self._briefing)
        (action,) = self._policy.act([self._pilot], [view])
        return int(Action.STAY) if self._mode.has_stopped(view.cell) else action

    def tally(self) -> dict[str, float]:
        """Return the tally of the policy's own pilot."""
        return self._pilot.tally()


@dataclass(frozen=True, kw_only=True)
class WithFault(Policy):
    """A policy of which one UAV has a mode's fault."""

    policy: Policy
    mode: FailureMode

    @property
    def privileged(self) -> bool:  # type: ignore[override]  # as the policy says
        """Whether the policy asks for the true map."""
        return is_privileged(self.policy)

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the policy's own pilot, wrapped for the faulty UAV."""
        faulty = briefing.agent == FAULTY
        return FaultyPilot(self.policy, briefing, self.mode) if faulty else self.policy.pilot(briefing)

    def act(self, pilots: Sequence[Pilot], views: Sequence[View]) -> list[int]:
        """Ask one UAV after the other."""
        return [
            pilot.act(view) if isinstance(pilot, FaultyPilot) else self.policy.act([pilot], [view])[0]
            for pilot, view in zip(pilots, views, strict=True)
        ]


class ModeFlight(NamedTuple):
    """How far a policy came in a mode."""

    mode: FailureMode
    steps: int
    """Steps flown: up to the one after which all were finished, or the budget."""
    agent: int
    """The UAV that knows the smallest ``share`` of the cells that it can reach, but for UAVs that have stopped."""
    share: float
    trace: Trace

    @property
    def finished(self) -> bool:
        """Whether every UAV knows enough."""
        return self.share >= FINISHED


def fly_failure_mode(
    policy: Policy,
    mode: FailureMode,
    *,
    radio: Mapping[str, Any] | None = None,
    seed: int = FIRST.seed,
    shape: tuple[int, int] = SHAPE,
) -> ModeFlight:
    """Fly a policy in a mode to its end or to the budget.

    Args:
        policy: The policy.
        mode: One of :data:`FAILURE_MODES`.
        radio: Settings of the radio, such as ``{"radio.model": "disc", "radio.range": 6}``; None for those of the mode.
        seed: Of the pilots' generators and of the order of moves.
        shape: (H, W) of the map.

    Raises:
        CannotFly: the policy raises, answers for another number of UAVs, or changes a view.

    """
    setup = Setup(seed, mode.floorplan(shape), mode.spawns)
    flight = CheckedFlight(
        WithFault(policy=policy, mode=mode), mode.scenario(shape, radio or {}), [setup], unseen=False
    )
    (trace,) = flight.fly(BUDGET, until=lambda world: min(known_shares(world, mode).values()) >= FINISHED)
    shares = known_shares(flight.world, mode)
    agent = min(shares, key=lambda n: shares[n])
    return ModeFlight(mode, int(flight.world.state.step[0]), agent, shares[agent], trace)


def known_shares(world: World, mode: FailureMode) -> dict[int, float]:
    """Return for each UAV that can still explore the share of the cells it can reach that its own map has."""
    state, free = world.state, world.state.truth[0] == FREE
    cells = [(int(row), int(col)) for row, col in state.cell[0]]
    exploring = set(range(len(cells)))
    if len(cells) > FAULTY and mode.has_stopped(cells[FAULTY]):
        exploring.remove(FAULTY)
        free[cells[FAULTY]] = False
    labels, _ = connected_parts(free)
    return {n: float((state.belief[0, n][labels == labels[cells[n]]] == FREE).mean()) for n in sorted(exploring)}


def check_failure_modes(harness: Harness) -> str:
    """Fly every mode; warn of those that are not finished, and of slow decisions."""
    known = {kind for trace in harness.alone for kind in trace.violations}
    shape = harness.map_shape or SHAPE
    if any(one < other for one, other in zip(shape, SHAPE, strict=True)):
        return f"not flown: the policy's map_shape is below {SHAPE[0]}x{SHAPE[1]}"
    flights = []
    for mode in FAILURE_MODES:
        try:
            flight = fly_failure_mode(harness.policy, mode, shape=shape)
        except CannotFly as error:
            raise CannotFly(f"in {mode.name}, {error.found}", error.fix) from error
        for kind in flight.trace.violations.keys() - known:
            found = flight.trace.violations[kind]
            raise Violation(f"in {mode.name}, {found.found}", found.fix)
        flights.append(flight)
    return _summary(flights)


def _summary(flights: list[ModeFlight]) -> str:
    late = [f"{flight.mode.name} {int(100 * flight.share)} %" for flight in flights if not flight.finished]
    slowest = {flight.mode.name: max(flight.trace.seconds, default=0.0) for flight in flights}
    slow = {name: seconds for name, seconds in slowest.items() if seconds > SLOW}
    last = max(flights, key=lambda each: each.steps)
    text = f"all {len(flights)} finished within {last.steps} of {BUDGET} steps ({last.mode.name} took longest)"
    if late:
        done = len(flights) - len(late)
        text = f"{done} of {len(flights)} finished in {BUDGET} steps; known in the others: {', '.join(late)}"
    if slow:
        text += "; a decision took " + ", ".join(f"{seconds:.1f} s in {name}" for name, seconds in slow.items())
    return Warned(text) if late or slow else text
