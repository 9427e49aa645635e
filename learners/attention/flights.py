"""Training and evaluation flights: tasks drawn by a seed, and the choices of every UAV."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.generators.thesis import ThesisMaps
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.scenarios.presets import on_files
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.world import World
from indoor_explorers.learners.attention.graph import TRUE_FEATURES, Graph, GraphSettings, true_graph
from indoor_explorers.learners.attention.network import Loaded, scores
from indoor_explorers.learners.attention.policy import AttentionPilot, probabilities
from indoor_explorers.learners.pockets.maps import TrainingMaps
from indoor_explorers.learners.pockets.tasks import team_settings

#: Lidar ranges in cells and numbers of UAVs, each with their shares of the flights.
RANGES, RANGE_SHARES = (10.0, 7.0, 14.0), (0.7, 0.15, 0.15)
TEAMS, TEAM_SHARES = (1, 2, 3), (0.6, 0.25, 0.15)
#: Share of flights in the thesis's rooms, and the lidar range there.
ROOMS, ROOM_RANGE = 0.2, 3.0
#: Most blocks of a map, as its free cells by the cells of a block: graphs of larger maps take too long to learn from.
MOST_BLOCKS = 70
#: Steps of a flight for each free cell of the map, and the least number.
BUDGET, LEAST_BUDGET = 0.6, 120
#: Coverage at which a flight ends.
ENOUGH = 0.99


class Choice(NamedTuple):
    """One choice of a flight, as the replay keeps it."""

    features: NDArray[np.float16]
    """(N, FEATURES) of the known map's graph."""
    neighbours: NDArray[np.int16]
    """(N, K)."""
    true_features: NDArray[np.float16]
    """(M, TRUE_FEATURES) of the true map's graph; (0, TRUE_FEATURES) without a privileged critic."""
    true_neighbours: NDArray[np.int16]
    """(M, K)."""
    actions: NDArray[np.int16]
    """(K,) nodes that it was made among, -1 for none."""
    chosen: int
    """Which of the K nodes was chosen."""
    gain: float = 0.0
    """Cells that the UAV discovered until the next choice, in squared lidar ranges."""
    duration: float = 0.0
    """Steps until then, in lidar ranges."""
    follows: int = 0
    """1 if the next choice of the UAV follows, 0 if the flight reached its goal, -1 if it was cut short."""


def drawn_task(maps: TrainingMaps, seed: int, settings: GraphSettings) -> World:
    """Return a world with one episode: map, lidar, team and radio are drawn by the seed."""
    rng = np.random.default_rng([seed, 17])
    room = bool(rng.random() < ROOMS)
    reach = ROOM_RANGE if room else float(rng.choice(RANGES, p=RANGE_SHARES))
    team = int(rng.choice(TEAMS, p=TEAM_SHARES))
    plan = _drawn_map(maps, rng, settings.side(reach), seed, room=room)
    budget = max(LEAST_BUDGET, round(BUDGET * np.count_nonzero(plan.truth == FREE)))
    asked = {"lidar.range": reach, "budget": budget, **team_settings(team, rng)}
    world = World(on_files(("map",), None).with_settings(asked).for_evaluation().with_settings({"goal": ENOUGH}))
    world.begin(0, seed, floorplan=plan)
    return world


def _drawn_map(maps: TrainingMaps, rng: np.random.Generator, side: int, seed: int, *, room: bool) -> Floorplan:
    if room:
        return ThesisMaps(obstacles=int(rng.integers(0, 8))).floorplan(0, seed)
    plan = maps.draw(rng)
    while np.count_nonzero(plan.truth == FREE) > MOST_BLOCKS * side**2:
        plan = maps.draw(rng)
    return plan


@dataclass(frozen=True, kw_only=True)
class _Recorder(Policy):
    """The policy of a training flight."""

    loaded: Loaded
    truth: Belief | None
    rng: np.random.Generator
    choices: dict[int, list[Choice]]

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return RecordingPilot(briefing, self)


class RecordingPilot(AttentionPilot):
    """Draw from the policy, and record the choices."""

    def __init__(self, briefing: Briefing, recorder: _Recorder) -> None:
        super().__init__(briefing, recorder.loaded, guard=False)
        self._recorder = recorder
        self._choices = recorder.choices.setdefault(briefing.agent, [])
        self._gain, self._since = 0.0, 0

    def pick(self, view: View, graph: Graph, allowed: Mask) -> int:
        """Return which neighbour was drawn."""
        recorder = self._recorder
        self.close(view.step, 1)
        chosen = int(recorder.rng.choice(len(allowed), p=probabilities(scores(graph, self._loaded), allowed)))
        seen = graph._replace(features=np.zeros((0, TRUE_FEATURES), np.float32), neighbours=graph.neighbours[:0])
        if recorder.truth is not None:
            steps, around = self.steps_from(view, view.cell), self.surroundings(view)
            seen = true_graph(view.belief, recorder.truth, view.cell, steps, around, self._loaded.graph)
        self._choices.append(
            Choice(
                graph.features.astype(np.float16),
                graph.neighbours.astype(np.int16),
                seen.features.astype(np.float16),
                seen.neighbours.astype(np.int16),
                np.where(allowed, graph.neighbours[0], -1).astype(np.int16),
                chosen,
            )
        )
        self._since = view.step
        return chosen

    def discover(self, cells: int) -> None:
        """Count newly discovered cells for the latest choice."""
        self._gain += cells

    def close(self, step: int, follows: int) -> None:
        """Complete the latest choice at a step."""
        if self._choices:
            reach = float(self.briefing.lidar_range)
            gain, duration = self._gain / reach**2, (step - self._since) / reach
            self._choices[-1] = self._choices[-1]._replace(gain=gain, duration=duration, follows=follows)
        self._gain = 0.0


class Flown(NamedTuple):
    """A training flight."""

    choices: list[Choice]
    """Those of one UAV after the other."""
    steps: int


def fly(world: World, loaded: Loaded, rng: np.random.Generator, *, privileged: bool) -> Flown:
    """Return a flight with choices drawn from the policy; ``privileged``: record the graphs of the true map too."""
    truth = world.state.truth[0].copy() if privileged else None
    policy = _Recorder(loaded=loaded, truth=truth, rng=rng, choices={})
    pilots = make_pilots(policy, world)
    for _ in rollout(world, ask_pilots(policy, pilots, world)):
        for (_, agent), pilot in pilots.items():
            pilot.discover(int(world.state.discovered[0, agent]))  # type: ignore[attr-defined]  # all are recorders
    steps, reached = int(world.state.step[0]), bool(world.state.team_covered[0] >= world.state.needed[0])
    for pilot in pilots.values():
        pilot.close(steps, 0 if reached else -1)  # type: ignore[attr-defined]  # likewise
    return Flown([choice for uav in policy.choices.values() for choice in uav], steps)


@dataclass(frozen=True, kw_only=True)
class _Greedy(Policy):
    """The policy of an evaluation flight."""

    loaded: Loaded

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return AttentionPilot(briefing, self.loaded, guard=False)


def greedy(world: World, loaded: Loaded) -> Iterator[NDArray[np.int64]]:
    """Fly without the guard to the end of the episode, always to the neighbour of highest score; yield each step."""
    policy = _Greedy(loaded=loaded)
    return rollout(world, ask_pilots(policy, make_pilots(policy, world), world))
