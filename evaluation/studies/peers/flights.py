"""Flights of policies and of the simulator's own expert on the simulator's maps, and the file that keeps them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from indoor_explorers.env import Briefing, InputError, Policy, Scenario, make_policy
from indoor_explorers.env.errors import described
from indoor_explorers.evaluation.harness.reported.rows import Strict
from indoor_explorers.evaluation.studies.peers.by_cells import SCALE, CellChoice, shown_shape
from indoor_explorers.evaluation.studies.peers.by_nodes import Chooser, NodeChoice, Rule, rule_of
from indoor_explorers.evaluation.studies.peers.dare import CELL, LIDAR_RANGE, MOST_MOVES, DareSimulator
from indoor_explorers.evaluation.studies.peers.graph import GraphState
from indoor_explorers.planners.toolbox.peers.process import PeerFailure

#: The name of the simulator's own planner among the policies.
EXPERT = "expert"
#: The file of a results folder that holds flights.
FILE = "flights.csv"
#: How a policy is to be taken to the simulator's nodes.
Adapter = Literal["auto", "nodes", "cells"]
#: Who chooses the nodes: the simulator's own planner, or a pilot by nodes or by cells.
ChosenBy = Literal["own", "nodes", "cells"]
#: Steps of a view's budget: more than any pilot flies here.
BUDGET = 20_000


class Flight(Strict):
    """One episode in the simulator; distances are in metres."""

    policy: str
    chosen_by: ChosenBy
    map: str
    seed: int
    scans_on_the_way: bool = False
    """Whether the robot scanned in every cell that it passed, and not at nodes alone, as it does by DARE's rules."""
    moves: int = 0
    metres: float = 0.0
    """Flown until the end."""
    metres_90: float | None = None
    """Flown until 90 % of the free cells were known; None if never."""
    metres_99: float | None = None
    explored: float = 0.0
    """Share of the free cells known at the end."""
    done: bool = False
    """Whether it ended because nothing was left to see by the simulator's own rule."""
    failure: str | None = None
    """Why the simulator or the policy failed; such a flight is flown again next time."""

    @property
    def key(self) -> tuple[str, str, int, bool]:
        """What identifies it."""
        return self.policy, self.map, self.seed, self.scans_on_the_way


def chosen_by(policy: str, adapter: Adapter) -> ChosenBy:
    """Return how a policy is flown.

    Raises:
        InputError: there is no such policy, or it cannot be flown so.

    """
    if policy == EXPERT:
        return "own"
    made = make_policy(policy)
    if made.privileged:
        raise InputError(f"policy {policy!r} needs the true map, which the simulator does not give; leave it out")
    by_nodes = _rule(made) is not None
    if adapter == "nodes" and not by_nodes:
        raise InputError(f"--adapter nodes: policy {policy!r} has no rule for nodes; use auto or cells")
    return "nodes" if by_nodes and adapter != "cells" else "cells"


def _briefing(resolution: float, shape: tuple[int, int], seed: int) -> Briefing:
    """Return the briefing of a pilot: one UAV that is to see everything."""
    reach = LIDAR_RANGE / resolution
    scenario = Scenario.model_validate({"name": "dare", "lidar": {"range": reach}, "goal": 1.0, "budget": BUDGET})
    rng = np.random.default_rng(seed)
    return Briefing(agent=0, team=1, shape=shape, lidar_range=reach, scenario=scenario, rng=rng)


def _rule(policy: Policy) -> Rule | None:
    """Return the rule by which a policy chooses nodes, None if it cannot."""
    return rule_of(policy.pilot(_briefing(CELL, (64, 64), 0)))


def _chooser(policy: str, how: ChosenBy, shape: tuple[int, ...], seed: int) -> Chooser | None:
    """Return what chooses the nodes in one episode on an (H, W) map, None for the simulator's own planner."""
    if how == "own":
        return None
    made = make_policy(policy)
    if how == "nodes" and (rule := _rule(made)) is not None:
        return NodeChoice(rule, LIDAR_RANGE, np.random.default_rng(seed))
    small = shown_shape(shape)
    return CellChoice(made.pilot(_briefing(SCALE * CELL, small, seed)), small, BUDGET)


def fly(simulator: DareSimulator, policy: str, adapter: Adapter, name: str, seed: int) -> Flight:
    """Fly one episode; a failure of the simulator's process or of the policy is told in the flight.

    Raises:
        InputError: the process cannot be started.

    """
    how = chosen_by(policy, adapter)
    scans = simulator.scans_on_the_way
    flight = Flight(policy=policy, chosen_by=how, map=Path(name).stem, seed=seed, scans_on_the_way=scans)
    try:
        state = simulator.begin(name, seed)
        chooser = _chooser(policy, how, state.belief.shape, seed)
        flight = _seen(flight, state, 0)
        while not state.done and flight.moves < MOST_MOVES and len(state.useful):
            state = simulator.move(None if chooser is None else state.first_move(chooser.choose(state)))
            flight = _seen(flight, state, flight.moves + 1)
    except InputError:
        raise
    except Exception as error:
        told = str(error) if isinstance(error, PeerFailure) else described(error)
        return flight.model_copy(update={"failure": told})
    return flight


def _seen(flight: Flight, state: GraphState, moves: int) -> Flight:
    """Return a flight after a move."""
    update: dict[str, object] = {"moves": moves, "metres": state.metres, "explored": state.explored}
    for key, share in (("metres_90", 0.9), ("metres_99", 0.99)):
        if getattr(flight, key) is None and state.explored >= share:
            update[key] = state.metres
    return flight.model_copy(update=update | {"done": state.done})


def flights(
    simulator: DareSimulator,
    policies: Sequence[str],
    adapter: Adapter,
    tasks: Iterable[tuple[str, int]],
    held: Sequence[Flight] = (),
) -> Iterator[Flight]:
    """Yield the flights that are not held yet, map by map, policy by policy."""
    known = {each.key for each in held if each.failure is None}
    for name, seed in tasks:
        for policy in policies:
            if (policy, Path(name).stem, seed, simulator.scans_on_the_way) not in known:
                yield fly(simulator, policy, adapter, name, seed)
