"""One flight of a batch, and the record that is made of it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from indoor_explorers.env import Pilot, Scenario, World
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.simulation.state import End
from indoor_explorers.evaluation.episodes.lower_bounds import least_steps
from indoor_explorers.evaluation.episodes.metrics import LEVELS, team_metrics
from indoor_explorers.evaluation.episodes.record import Outcome, Record
from indoor_explorers.evaluation.episodes.recorder import Flown, Log
from indoor_explorers.evaluation.episodes.shared_steps import Steps
from indoor_explorers.evaluation.episodes.stalling import behaviour_metrics
from indoor_explorers.evaluation.experiment.experiment import Task


@dataclass
class RunningEpisode:
    """One running episode of a batch."""

    place: int
    task: Task
    bound: int = 0
    """Steps that no team can do without on its way to 99 %."""
    pilots: list[Pilot] = field(default_factory=list)
    latencies: list[float] = field(default_factory=list)
    """Seconds of each decision."""
    tallies: dict[str, float | None] = field(default_factory=dict)
    """Means over the UAVs of what their pilots tallied, prefixed by ``pilot_``."""
    failure: str = ""

    @classmethod
    def begin(cls, world: World, place: int, task: Task, floorplan: Floorplan) -> RunningEpisode:
        """Begin an episode in its place of the world."""
        world.begin(place, task.seed, floorplan=floorplan)
        return cls(place, task, least_steps(world, place, LEVELS["t99"]))

    def record(self, policy: str, world: World, flown: Flown) -> Record:
        """Return the record of the episode, which has just ended."""
        state, b = world.state, self.place
        outcome, reason = self._outcome(world)
        return Record(
            policy=policy,
            task=self.task,
            floorplan=world.floorplan(b),
            team=world.scenario.team,
            budget=int(state.budget[b]),
            reachable=int(state.total[b]),
            outcome=outcome,
            reason=reason,
            steps=len(flown.actions),
            metrics=self._metrics(world, flown),
            covered=flown.covered,
            cells=flown.cells,
            actions=flown.actions,
            seconds=flown.seconds,
            sent=flown.sent,
        )

    def _outcome(self, world: World) -> tuple[Outcome, str]:
        ends = [End(int(end)) for end in world.state.end[self.place]]
        if self.failure:
            return Outcome.FAILED, self.failure
        if End.GOAL in ends:
            return Outcome.COMPLETE, ""
        if End.BUDGET in ends:
            return Outcome.BUDGET, ""
        return Outcome.ENDED, ", ".join(f"UAV {n}: {end.name.lower().replace('_', ' ')}" for n, end in enumerate(ends))

    def _metrics(self, world: World, flown: Flown) -> dict[str, float | None]:
        state, b = world.state, self.place
        sensed, total, budget = state.sensed_count[b], int(state.total[b]), int(state.budget[b])
        covered = int(flown.covered[-1, 0])
        of_team = team_metrics(flown.covered, total, budget)
        late = of_team["t99"] if of_team["t99"] is not None else budget
        return {
            **of_team,
            "t99_to_bound": late / self.bound if self.bound else None,
            "path_length": float(state.path_length[b].sum()),
            "path_max": float(state.path_length[b].max()),
            "overlap": float((sensed.sum() - covered) / covered),
            "balance": float((sensed / total).std()),
            "collisions": float(state.collisions[b].sum()),
            "blocked": float(state.blocked[b].sum()),
            **behaviour_metrics(world, b, flown),
            "messages_bytes": float(flown.sent[-1]),
            "age_of_information": flown.age,
            "latency_total_s": float(flown.seconds[-1]),
            "latency_p50_us": float(np.percentile(self.latencies, 50) * 1e6) if self.latencies else None,
            "latency_p99_us": float(np.percentile(self.latencies, 99) * 1e6) if self.latencies else None,
            **self.tallies,
        }


def failed_record(
    flight: RunningEpisode, policy: str, scenario: Scenario, floorplan: Floorplan, steps: Steps
) -> Record:
    """Return the record of an episode that broke off, from the steps before: they are flown again.

    So everything in it is what it was after the last whole step, whatever became of the world it was flown in.
    """
    world = World(scenario)
    again = replace(
        RunningEpisode.begin(world, 0, flight.task, floorplan), latencies=flight.latencies, failure=flight.failure
    )
    log = Log(world)
    for actions in steps.actions:
        world.step(actions[None])
        log.add(actions[None], np.zeros(1))
    flown = log.flown(0)
    flown.seconds[1:], flown.sent[1:] = steps.seconds, steps.sent
    return again.record(policy, world, flown)
