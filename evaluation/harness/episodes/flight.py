"""One episode of one policy, flown in this process step by step, whose pilots can be asked to explain themselves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Explanation, Pilot, Policy, Scenario, World
from indoor_explorers.env.errors import RunError, described
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.explanation import SILENT
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.resimulate import on_levels

#: What explains the last move of each UAV, step by step from the first on.
Told = Iterator[list[Explanation | None]]


class Flight:
    """The episode of a seed, which is the one that :mod:`~.runner` flies in a batch of one.

    Args:
        policy: Policy of all UAVs.
        scenario: Scenario.
        seed: Seed of the episode.
        floorplan: Its map; by default the scenario's first one, or the one that its generator makes of the seed.
        explaining: Whether pilots keep what explains their actions; nobody may measure such a flight.

    """

    def __init__(
        self, policy: Policy, scenario: Scenario, seed: int, floorplan: Floorplan | None = None, *, explaining: bool
    ) -> None:
        self._policy, self._explaining = policy, explaining
        self.world = World(scenario)
        self.world.begin(0, seed, floorplan=floorplan or draw_floorplan(scenario, seed))
        self.pilots: list[Pilot] = []
        """The pilot of each UAV, once the flight goes on."""
        self.flew: Mask = np.zeros(scenario.team, np.bool_)
        """(N,) which UAVs flew in the last step."""

    @property
    def step(self) -> int:
        """Steps flown."""
        return int(self.world.state.step[0])

    def steps(self) -> Iterator[NDArray[np.int64]]:
        """Fly to the end of the episode; yield the (N,) actions after each step.

        Raises:
            RunError: the policy failed.

        """
        try:
            pilots = make_pilots(self._policy, self.world)
            self.pilots = [pilots[0, agent] for agent in range(len(pilots))]
            for pilot in self.pilots:
                pilot.explaining = self._explaining
            flying = self.world.flying[0].copy()
            for actions in rollout(self.world, ask_pilots(self._policy, pilots, self.world)):
                self.flew, flying = flying, self.world.flying[0].copy()
                yield actions[0]
        except Exception as error:
            raise RunError(f"policy failed at step {self.step}: {described(error)}") from error

    def explanations(self) -> list[Explanation | None]:
        """Return what explains the last move of each UAV; None for those that did not fly, and for all at the start.

        Raises:
            RunError: a pilot failed.

        """
        try:
            pairs = zip(self.flew.tolist(), self.pilots, strict=False)
            return [pilot.explain() if flew else None for flew, pilot in pairs] or [None] * len(self.flew)
        except Exception as error:
            raise RunError(f"explain() failed at step {self.step}: {described(error)}") from error


def explained_again(record: Record, scenario: Scenario, policy: Policy) -> Told:
    """Fly a recorded episode again with its policy; yield what explains each UAV's move, after each of its S steps.

    Raises:
        RunError: the policy failed, or flew differently; it is told at the first other move.

    """
    flown = on_levels(scenario, record.floorplan.level_count)
    flight = Flight(policy, flown, record.task.seed, record.floorplan, explaining=True)
    for actions in flight.steps():
        if flight.step > record.steps or not np.array_equal(actions, record.actions[flight.step - 1]):
            raise RunError(f"flown again, it took another action at step {flight.step} than recorded")
        if all(type(pilot).explain is Pilot.explain for pilot in flight.pilots):
            raise RunError(SILENT)
        yield flight.explanations()
    if flight.step < record.steps:
        raise RunError(f"flown again, it ended at step {flight.step}, not {record.steps}")
