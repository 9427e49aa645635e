"""A running episode of a batch, and its record."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import UNKNOWN, Scenario, World
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.search.any_angle import straightened_length
from indoor_explorers.env.simulation.state import End
from indoor_explorers.evaluation.harness.episodes.lower_bounds import least_steps
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, stop_metrics, team_metrics
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.episodes.recorder import Log
from indoor_explorers.evaluation.harness.episodes.stalling import behaviour_metrics
from indoor_explorers.evaluation.harness.episodes.steps import Steps
from indoor_explorers.evaluation.harness.episodes.surface import seen_share, surface_of
from indoor_explorers.evaluation.harness.experiment.experiment import Task


@dataclass
class RunningEpisode:
    """One running episode of a batch."""

    place: int
    task: Task
    floorplan: Floorplan
    bound: int | None = None
    """Lower bound on the steps to 99 %; None before it is computed."""
    latencies: list[float] = field(default_factory=list)
    """Seconds of each decision."""
    tallies: dict[str, float | None] = field(default_factory=dict)
    """Pilot statistics: means over the UAVs, with names prefixed by ``pilot_``."""
    failure: str = ""
    done: int | None = None
    """Step at which all UAVs that flew would first have ended the mission; None for never."""

    def declare_done(self, step: int) -> None:
        """Note that all UAVs that fly would end the mission at this step."""
        self.done = step if self.done is None else self.done

    def begin(self, world: World) -> None:
        """Begin the episode in its place of the batch."""
        world.begin(self.place, self.task.seed, floorplan=self.floorplan)
        if self.bound is None:
            self.bound = least_steps(world, self.place, LEVELS["t99"])

    def record(self, policy: str, world: World, log: Log, steps: Steps) -> Record:
        """Return the record of the episode, which has just ended; its ``steps`` are those of the log."""
        state, b = world.state, self.place
        outcome, reason = self._outcome(world)
        return Record(
            **vars(steps),
            policy=policy,
            task=self.task,
            floorplan=self.floorplan,
            team=world.scenario.team,
            budget=int(state.budget[b]),
            reachable=int(state.total[b]),
            outcome=outcome,
            reason=reason,
            metrics=self._metrics(world, log, steps),
        )

    def _longest_straightened(self, steps: Steps) -> float | None:
        """Return the metres that the UAV flew that flew farthest, staircases as straight lines; None on levels."""
        if self.floorplan.resolution is None or self.floorplan.level_count > 1:
            return None
        truth, tracks = self.floorplan.truth, np.ascontiguousarray(steps.cells.swapaxes(0, 1).astype(np.int64))
        return self.floorplan.resolution * max(straightened_length(truth, track) for track in tracks)

    def _outcome(self, world: World) -> tuple[Outcome, str]:
        ends = [End(int(end)) for end in world.state.end[self.place]]
        if self.failure:
            return Outcome.FAILED, self.failure
        if End.GOAL in ends:
            return Outcome.COMPLETE, ""
        if End.BUDGET in ends:
            return Outcome.BUDGET, ""
        return Outcome.ENDED, ", ".join(f"UAV {n}: {end.name.lower().replace('_', ' ')}" for n, end in enumerate(ends))

    def _metrics(self, world: World, log: Log, steps: Steps) -> dict[str, float | None]:
        state, b = world.state, self.place
        sensed, total, budget = state.sensed_count[b], int(state.total[b]), int(state.budget[b])
        covered = int(state.team_covered[b])
        of_team = team_metrics(steps.covered, world.scenario.team, total, budget)
        late = of_team["t99"] if of_team["t99"] is not None else budget
        return {
            **of_team,
            "t99_to_bound": late / self.bound if self.bound else None,
            "path_length": float(state.path_length[b].sum()),
            "path_max": float(state.path_length[b].max()),
            "path_max_m": self._longest_straightened(steps),
            "overlap": float((sensed.sum() - covered) / covered) if covered else None,
            "balance": float((sensed / total).std()),
            "collisions": float(state.collisions[b].sum()),
            "blocked": float(state.blocked[b].sum()),
            **({"surface": seen_share(world, b, surface_of(world, b))} if self.floorplan.level_count > 1 else {}),
            **({"stopped": float((state.end[b] == End.STOPPED).sum())} if world.scenario.failures.any else {}),
            **(map_metrics(world, b, log.flown_steps[b]) if world.scenario.uncertain else {}),
            **behaviour_metrics(world, b, steps, log.flown_steps[b]),
            "messages_bytes": float(steps.sent[-1]),
            "age_of_information": log.age(b),
            "latency_total_s": float(steps.seconds[-1]),
            "latency_p50_us": float(np.percentile(self.latencies, 50) * 1e6) if self.latencies else None,
            "latency_p99_us": float(np.percentile(self.latencies, 99) * 1e6) if self.latencies else None,
            **({} if self.done is None else stop_metrics(steps.covered[:, 0] / total, self.done)),
            **self.tallies,
        }


def simulated_record(flight: RunningEpisode, policy: str, scenario: Scenario, flown: Steps) -> Record:
    """Return the record of an episode whose ``flown`` steps are simulated again from its actions.

    So everything in it but times and bytes follows from the actions, whatever happened to the world it was flown in.
    It has fewer steps than were flown where the episode is over before.
    """
    world, again = World(scenario), replace(flight, place=0)
    again.begin(world)
    log = Log(world)
    for actions in flown.actions:
        if not log.running.any():
            break
        world.step(actions[None])
        log.add(actions[None], np.zeros(1))
    steps = log.steps(0)
    steps.seconds[1:], steps.sent[1:] = flown.seconds[1 : steps.steps + 1], flown.sent[1 : steps.steps + 1]
    return again.record(policy, world, log, steps)


def map_metrics(world: World, episode: int, flown: NDArray[np.integer]) -> dict[str, float | None]:
    """Return ``map_error``, ``claimed`` and ``pose_error`` of an episode that has ended.

    ``flown`` (N,) is the number of steps that each UAV flew.
    """
    assert world.slam is not None
    state = world.state
    shown, truth = state.union[episode], state.truth[episode]
    known, steps = shown != UNKNOWN, int(flown.sum())
    return {
        "map_error": float((shown != truth)[known].mean()) if known.any() else None,
        "claimed": world.claimed_coverage(episode),
        "pose_error": float(world.slam.pose_error[episode].sum() / steps) if steps else None,
    }
