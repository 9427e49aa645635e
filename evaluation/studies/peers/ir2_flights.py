"""Flights of teams in the simulator of IR2, and the file that keeps them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from indoor_explorers.env import Briefing, InputError, Pilot, Scenario, make_policy
from indoor_explorers.env.errors import described
from indoor_explorers.evaluation.harness.reported.rows import Strict
from indoor_explorers.evaluation.studies.peers.by_path import SCALE, TeamChoice, Turn
from indoor_explorers.evaluation.studies.peers.ir2 import (
    LIDAR_RANGE,
    RADIO_RANGE,
    SETS,
    Ir2Simulator,
    Task,
)
from indoor_explorers.planners.toolbox.peers.process import PeerFailure

#: The file of a results folder that holds flights of teams.
FILE = "team-flights.csv"
#: Coverage at which a flight ends, and steps of a view's budget: more than any pilot flies here.
GOAL, BUDGET = 0.99, 20_000


class TeamFlight(Strict):
    """One episode in the simulator."""

    policy: str
    part: str
    """The test set."""
    map: str
    seed: int
    mended: bool
    """Whether robots out of contact no longer write into one map."""
    steps: int = 0
    """Moves of each robot."""
    pixels: float = 0.0
    """Flown by the robot that flew most."""
    explored: float = 0.0
    """Share of the free pixels known at the end to the robot that knew least."""
    done: bool = False
    """Whether every robot knew 99 % of them."""
    failure: str | None = None
    """Why the simulator or the policy failed; such a flight is flown again next time."""

    @property
    def key(self) -> tuple[str, str, str, bool]:
        """What identifies it."""
        return self.policy, self.part, self.map, self.mended


def pilots(policy: str, team: int, shape: tuple[int, int], seed: int) -> list[Pilot]:
    """Return the pilots of a team that is done once each of them knows 99 % of an (H, W) map.

    Raises:
        InputError: there is no such policy, or it needs the true map.

    """
    settings = {
        **{"name": "ir2", "team": team, "spawn": "clustered", "budget": BUDGET, "goal": GOAL, "goal_of": "every"},
        **{"lidar": {"range": LIDAR_RANGE / SCALE}, "radio": {"model": "path-loss-ir2", "range": RADIO_RANGE / SCALE}},
    }
    scenario, made = Scenario.model_validate(settings), make_policy(policy)
    if made.privileged:
        raise InputError(f"policy {policy!r} needs the true map, which the simulator does not give; leave it out")
    generators = [np.random.default_rng((seed, k)) for k in range(team)]
    told = [
        Briefing(agent=k, team=team, shape=shape, lidar_range=LIDAR_RANGE / SCALE, scenario=scenario, rng=rng)
        for k, rng in enumerate(generators)
    ]
    return [made.pilot(briefing) for briefing in told]


def fly(simulator: Ir2Simulator, policy: str, task: Task) -> TeamFlight:
    """Fly one episode; a failure of the simulator's process or of the policy is told in the flight.

    Raises:
        InputError: there is no such policy, it needs the true map, or the process cannot be started.

    """
    flight = TeamFlight(policy=policy, part=task.part, map=Path(task.map).stem, seed=task.seed, mended=simulator.mended)
    try:
        turn, settings = simulator.begin(task), SETS[task.part]
        team = TeamChoice(pilots(policy, settings.team, turn.shape, task.seed), turn, BUDGET)
        while not turn.done and turn.step < settings.most_steps:
            turn = simulator.move(team.choose(turn))
            team.exchange(turn)
            flight = _seen(flight, turn)
    except InputError:
        raise
    except Exception as error:
        told = str(error) if isinstance(error, PeerFailure) else described(error)
        return flight.model_copy(update={"failure": told})
    return flight


def _seen(flight: TeamFlight, turn: Turn) -> TeamFlight:
    """Return a flight after a move."""
    steps = turn.step + (turn.robot > 0)
    found = {"steps": steps, "pixels": float(turn.flown.max()), "explored": float(turn.explored.min())}
    return flight.model_copy(update=found | {"done": turn.done})


def flights(
    simulator: Ir2Simulator, policies: Sequence[str], tasks: Iterable[Task], held: Iterable[TeamFlight] = ()
) -> Iterator[TeamFlight]:
    """Yield the flights that are not held yet, map by map, policy by policy."""
    known = {each.key for each in held if each.failure is None}
    for task in tasks:
        for policy in policies:
            if (policy, task.part, Path(task.map).stem, simulator.mended) not in known:
                yield fly(simulator, policy, task)
