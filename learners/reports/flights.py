"""Training flights: UAVs choose at random whether to fly home, by the network's values; each choice is recorded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.registry import make_policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.scenarios.presets import on_files
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.world import World
from indoor_explorers.learners.pockets.maps import TrainingMaps
from indoor_explorers.learners.pockets.tasks import base_settings
from indoor_explorers.learners.reports.network import NetworkWeights, value
from indoor_explorers.learners.reports.policy import ReportsPilot
from indoor_explorers.learners.reports.situation import HIGHEST_LATE_COST, NUMBERS, POINTS, Situation
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors

#: Least and most free cells of a training map.
FEWEST, LARGEST = 600, 4200
#: Number of the random numbers of a flight beside its seed.
STREAM = 17
#: Coverage that the base is to know at the deadline.
ENOUGH = 0.99
#: What is missing at the deadline at a full late cost.
MISSING = 0.05
#: Numbers of the true state at a choice, which the value networks see.
TRUE = 6


class Choice(NamedTuple):
    """One choice of a flight."""

    situation: Situation
    step: int
    known: int
    """Cells that the UAV knew."""
    probability: float
    """With which flying home was drawn."""
    home: bool
    """Whether it was."""


class Choices(NamedTuple):
    """C choices, in the order of flights, UAVs and time."""

    numbers: NDArray[np.float32]
    """(C, NUMBERS) inputs of the network."""
    rules: NDArray[np.float32]
    """(C,) values of flying home to the rule."""
    true: NDArray[np.float32]
    """(C, TRUE): coverage of the base and of the team, the UAV's share of all cells, their number, the rate at which
    the rest would have to be seen, and the budget."""
    probabilities: NDArray[np.float32]
    """(C,) with which flying home was drawn."""
    home: NDArray[np.bool_]
    """(C,) whether it was."""
    rewards: NDArray[np.float32]
    """(C,) points until the next choice of the UAV, or the deadline, of 100 for coverage and late cost together."""
    durations: NDArray[np.float32]
    """(C,) time until then, in lidar ranges."""
    lengths: NDArray[np.int64]
    """(U,) number of choices of each UAV."""
    flight: NDArray[np.int64]
    """(U,) number of its flight."""
    results: NDArray[np.float64]
    """(F, 2): mean coverage of the base over the budget, and whether it knew enough at the deadline."""


@dataclass(frozen=True, kw_only=True)
class _Recorder(Policy):
    """The policy of a training flight."""

    explorer: str
    weights: NetworkWeights
    late_cost: float
    clear: float
    rng: np.random.Generator
    choices: dict[int, list[Choice]]

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        explorer = make_policy(self.explorer)
        return RecordingPilot(briefing, explorer, explorer.pilot(briefing), self)


class RecordingPilot(ReportsPilot):
    """Choose at random, with probabilities that grow with the value, and record the choice."""

    def __init__(self, briefing: Briefing, explorer: Policy, pilot: Pilot, recorder: _Recorder) -> None:
        super().__init__(briefing, explorer, pilot, recorder.weights, recorder.late_cost)
        self._recorder = recorder

    def pick(self, view: View, situation: Situation) -> bool:
        """Return the drawn choice."""
        clear = self._recorder.clear
        odds = max(-clear, min(clear, value(situation, self._recorder.weights)))
        probability = 1.0 / (1.0 + math.exp(-odds))
        home = bool(self._recorder.rng.random() < probability)
        choice = Choice(situation, view.step, self.known, probability, home)
        self._recorder.choices.setdefault(self.briefing.agent, []).append(choice)
        return home


def task(maps: TrainingMaps, rng: np.random.Generator) -> tuple[Floorplan, dict[str, Any]]:
    """Return a map, and the settings of a task on it with a home base and a deadline."""
    free = 0
    while not FEWEST <= free <= LARGEST:
        plan = maps.draw(rng)
        free = int(np.count_nonzero(plan.truth == FREE))
    return plan, base_settings(free, rng)


def draw_late_cost(rng: np.random.Generator) -> float:
    """Return how much the deadline matters in a flight: half of the flights have less than 24 points."""
    share = HIGHEST_LATE_COST / (POINTS + HIGHEST_LATE_COST) * rng.random() ** 2
    return float(POINTS * share / (1.0 - share))


def fly(maps: TrainingMaps, explorer: str, weights: NetworkWeights, clear: float, seed: int) -> Choices:
    """Return the choices of a flight: its map, lidar, team, radio, deadline and late cost are drawn by a seed.

    Values beyond ``clear``, either way, are drawn like ``clear``, so that each choice is tried.
    """
    rng = np.random.default_rng([seed, STREAM])
    plan, settings = task(maps, rng)
    world = World(on_files(("map",), None).with_settings(settings).for_evaluation())
    world.begin(0, seed, floorplan=plan)
    late_cost = draw_late_cost(rng)
    recorder = _Recorder(explorer=explorer, weights=weights, late_cost=late_cost, clear=clear, rng=rng, choices={})
    coverage, total = flown_coverage(world, recorder), int(world.state.total[0])
    uavs: Sequence[list[Choice]] = [*recorder.choices.values()] or [[]]
    reach, base = settings["lidar.range"], coverage[:, 0]
    team = world.scenario.team
    whole = joined([as_arrays(each, coverage, late_cost, total, team, reach) for each in uavs])
    return whole._replace(results=np.array([[base[1:].mean(), base[-1] >= ENOUGH]]))


def flown_coverage(world: World, policy: Policy) -> NDArray[np.float64]:
    """Fly a policy to the end; return the coverage of the base and of the team at each step of the budget, (B + 1, 2).

    After the end of the flight it stays as it is.
    """
    covered = [(world.base_coverage[0], world.team_coverage[0])]
    for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
        covered.append((world.base_coverage[0], world.team_coverage[0]))
    covered += covered[-1:] * (int(world.state.budget[0]) + 1 - len(covered))
    return np.array(covered)


def points_lost(coverage: float, late_cost: float) -> float:
    """Return the points that it costs if the base has a ``coverage`` at the deadline.

    Half of ``late_cost`` is lost as soon as it is less than ``ENOUGH``, and half in proportion to what is missing.
    """
    missing = max(0.0, ENOUGH - coverage)
    return late_cost / 2.0 * (float(missing > 0.0) + min(1.0, missing / MISSING))


def points_lost_until(base: NDArray[np.float64], late_cost: float) -> NDArray[np.float64]:
    """Return the points lost until each step of the budget, (B + 1,), from the coverage of the base (B + 1,).

    Those of the deadline are lost at the last step. All are scaled, so that those of flights with a high late cost do
    not outweigh the others.
    """
    lost = np.concatenate([[0.0], np.cumsum(1.0 - base[1:])]) / (len(base) - 1) * POINTS
    lost[-1] += points_lost(base[-1], late_cost)
    return np.asarray(lost * (POINTS / (POINTS + late_cost)))


def true_state(
    coverage: NDArray[np.float64],
    steps: NDArray[np.int64],
    known: NDArray[np.int64],
    total: int,
    team: int,
    lidar_range: float,
) -> NDArray[np.float32]:
    """Return the true state at C choices, (C, TRUE): see :attr:`Choices.true`.

    ``coverage`` (B + 1, 2) is that of the base and of the team at each step of the budget, ``total`` the number of
    cells, ``known`` (C,) those that the UAV knew at its choices after ``steps`` (C,).
    """
    at, left = coverage[steps], np.maximum(1, len(coverage) - 1 - steps)
    rate = (1.0 - at[:, 1]) * total / left / team / lidar_range
    whole = np.ones(len(steps))
    length = (len(coverage) - 1) * team * lidar_range / total / 10.0
    true = np.column_stack([at, known / total, whole * total / 4000.0, rate, whole * length])
    return true.astype(np.float32)


def as_arrays(
    choices: Sequence[Choice],
    coverage: NDArray[np.float64],
    late_cost: float,
    total: int,
    team: int,
    lidar_range: float,
) -> Choices:
    """Return the C choices of one UAV, without results.

    ``coverage`` (B + 1, 2) is that of the base and of the team at each step of the budget, ``total`` the number of
    cells.
    """
    steps = np.array([*(choice.step for choice in choices), len(coverage) - 1])
    rewards = -np.diff(points_lost_until(coverage[:, 0], late_cost)[steps])
    known = np.array([choice.known for choice in choices], np.int64)
    true = true_state(coverage, steps[:-1], known, total, team, lidar_range)
    return Choices(
        np.array([choice.situation.numbers for choice in choices], np.float32).reshape(-1, NUMBERS),
        np.array([choice.situation.rule for choice in choices], np.float32),
        true,
        np.array([choice.probability for choice in choices], np.float32),
        np.array([choice.home for choice in choices], np.bool_),
        rewards.astype(np.float32),
        (np.diff(steps) / lidar_range).astype(np.float32),
        np.array([len(choices)]),
        np.zeros(1, np.int64),
        np.zeros((0, 2)),
    )


def joined(parts: Sequence[Choices]) -> Choices:
    """Return the choices of several flights, one after the other; the numbers of flights go on."""
    first = np.cumsum([0, *(len(part.results) for part in parts)])
    moved = [part._replace(flight=part.flight + before) for part, before in zip(parts, first[:-1], strict=True)]
    return Choices(*(np.concatenate(arrays) for arrays in zip(*moved, strict=True)))


def write_choices(path: Path, choices: Choices) -> None:
    """Write choices to a file of arrays."""
    write_tensors(path, choices._asdict())


def read_choices(paths: Sequence[Path]) -> Choices:
    """Return the choices of some files, one after the other."""
    return joined([Choices(**read_tensors(path)[0]) for path in paths])
