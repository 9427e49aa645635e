"""Training flights: UAVs choose places at random by the network's values; each choice is recorded with the true map."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.scenarios.presets import on_files
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.world import World
from indoor_explorers.learners.places.network import Loaded
from indoor_explorers.learners.places.recording import Choice, Recorder, Recording
from indoor_explorers.learners.places.scene import MOST
from indoor_explorers.learners.places.truth import TrueMap
from indoor_explorers.learners.pockets.maps import TrainingMaps
from indoor_explorers.learners.pockets.tasks import base_settings, harder_settings, lidar_over_levels, team_settings
from indoor_explorers.learners.reports.flights import (
    TRUE,
    draw_late_cost,
    flown_coverage,
    points_lost_until,
    true_state,
)
from indoor_explorers.learners.reports.situation import LATE_COST
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors
from indoor_explorers.planners.toolbox.pockets.estimates import DEFAULT_FILES, EstimateFiles

Arrays = Mapping[str, NDArray[Any]]


class TrainingFlight(NamedTuple):
    """A training flight."""

    choices: list[dict[str, NDArray[Any]]]
    """Arrays of each UAV's choices: see :func:`~indoor_explorers.learners.places.flights.as_arrays`."""
    times: tuple[float, float]
    """Steps to 90 % and 99 % of the reachable cells, in units of these cells by the lidar's range; NaN for teams."""


class ChoiceArrays(NamedTuple):
    """C choices, in the order of flights, UAVs and time."""

    arrays: Arrays
    """Arrays (C, ...) by name: see :func:`~indoor_explorers.learners.places.flights.as_arrays`."""
    lengths: NDArray[np.int64]
    """(U,) number of choices of each UAV."""
    flight: NDArray[np.int64]
    """(U,) number of its flight."""
    times: NDArray[np.float64]
    """(F, 2) times of each flight, see :class:`TrainingFlight`."""

    @property
    def half(self) -> NDArray[np.int64]:
        """(C,) 0 or 1: the half of the flights that a choice belongs to."""
        return np.asarray(np.repeat(self.flight % 2, self.lengths))


def choices_of(flights: Sequence[TrainingFlight]) -> ChoiceArrays:
    """Return the choices of some flights, at least one."""
    uavs = [uav for flight in flights for uav in flight.choices]
    arrays = {name: np.concatenate([uav[name] for uav in uavs]) for name in uavs[0]}
    lengths = np.array([len(uav["chosen"]) for uav in uavs], np.int64)
    numbers = np.repeat(np.arange(len(flights)), [len(flight.choices) for flight in flights])
    return ChoiceArrays(arrays, lengths, numbers, np.array([flight.times for flight in flights], np.float64))


def write_choices(path: Path, choices: ChoiceArrays) -> None:
    """Write choices to a file of arrays."""
    about = {"uav.lengths": choices.lengths, "uav.flight": choices.flight, "flight.times": choices.times}
    write_tensors(path, {**choices.arrays, **about})


def read_choices(paths: Sequence[Path]) -> ChoiceArrays:
    """Return the choices of some files, one after the other."""
    parts = [read_tensors(path)[0] for path in paths]
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0] if name != "uav.flight"}
    first = np.cumsum([0, *(len(part["flight.times"]) for part in parts)])
    numbers = np.concatenate([part["uav.flight"] + before for part, before in zip(parts, first[:-1], strict=True)])
    lengths, times = whole.pop("uav.lengths"), whole.pop("flight.times")
    return ChoiceArrays(whole, lengths, numbers, times)


#: Least and most free cells of a training map: flights over larger ones take too long.
FEWEST, LARGEST = 400, 4500
#: Lidar ranges in cells and numbers of UAVs, each with their shares of the flights.
RANGES, RANGE_SHARES = (10.0, 7.0, 14.0), (0.8, 0.1, 0.1)
TEAMS, TEAM_SHARES = (1, 2, 4), (0.6, 0.2, 0.2)
#: Shares of these teams in harder tasks.
HARDER_TEAM_SHARES = (0.4, 0.25, 0.35)
#: Time that a cell counts as which is missing when all UAVs have stopped, as a multiple of that of the free cells by
#: the lidar's range. Flights to 99 % take some three times the latter, and the last cells of them longer.
MISSING = 5.0
#: Cost of a step before 90 % coverage, beyond that of every step, which is 1.
EARLY = 0.5
#: Lidar ranges of flight that a point costs where a home base waits.
POINT = 3.0
#: Discount factor per lidar range of flight; where a base waits what comes later counts as much.
DISCOUNT = 0.99
#: Coverage up to which a step costs more, and at which a flight ends.
MOSTLY, ENOUGH = 0.9, 0.99


def _task(plan: Floorplan, rng: np.random.Generator, harder: float, bases: float) -> dict[str, Any]:
    """Return the settings of a task on a map, drawn at random.

    In a share ``bases`` of them a base waits, in a share ``harder`` of the others it is a harder one.
    """
    if plan.level_count == 1:
        if bases > 0.0 and rng.random() < bases:
            return base_settings(int(np.count_nonzero(plan.truth == FREE)), rng)
        is_harder = harder > 0.0 and rng.random() < harder
        shares = HARDER_TEAM_SHARES if is_harder else TEAM_SHARES
        reach, team = float(rng.choice(RANGES, p=RANGE_SHARES)), int(rng.choice(TEAMS, p=shares))
        more = harder_settings(team, rng) if is_harder else {}
        return {"lidar.range": reach, "budget": None, **team_settings(team, rng), **more}
    return {"budget": None, **lidar_over_levels(plan, rng), **team_settings(int(rng.choice(TEAMS)), rng)}


def fly(
    maps: TrainingMaps,
    seed: int,
    loaded: Loaded,
    files: EstimateFiles = DEFAULT_FILES,
    harder: float = 0.0,
    bases: float = 0.0,
    options_alone: bool = False,
) -> TrainingFlight:
    """Return a flight of a network over a map drawn by a seed, with a lidar, team and radio drawn likewise.

    ``files`` has the weights of the estimates that the network sees. A share ``bases`` of the tasks has a home base
    and a deadline, a share ``harder`` of the others is harder. ``options_alone`` tells whether options are drawn
    alone: of the places the best one is flown to.
    """
    rng = np.random.default_rng([seed, 11])
    plan = maps.draw(rng)
    while not FEWEST <= np.count_nonzero(plan.truth == FREE) <= LARGEST:
        plan = maps.draw(rng)
    asked = _task(plan, rng, harder, bases)
    reach, team = asked["lidar.range"], asked["team"]
    world = World(on_files(("map",), None).with_settings(asked).for_evaluation())
    world.begin(0, seed, floorplan=plan)
    levels = plan.levels
    reachable = distance_field(plan.truth, world.view(0, 0).cell, levels.rise) < UNREACHABLE
    recording = Recording(TrueMap(plan.truth, reachable, levels), rng, {}, options_alone)
    has_base = "base.at" in asked
    late_cost = draw_late_cost(rng) if has_base else LATE_COST
    policy = Recorder(loaded=loaded, recording=recording, files=files, late_cost=late_cost)
    if has_base:
        return _reported(world, policy, late_cost)
    coverage = [_covered(world, loaded)]
    for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
        coverage.append(_covered(world, loaded))
        if coverage[-1] >= ENOUGH:
            break
    end, most = len(coverage) - 1, max(coverage)
    nominal = np.count_nonzero(reachable) / reach
    if most < ENOUGH and not world.flying.any() and end < world.view(0, 0).budget:
        end += math.ceil(MISSING * (ENOUGH - most) * nominal)
    t90 = int(np.argmax(np.array(coverage) >= MOSTLY)) if most >= MOSTLY else end
    steps = np.arange(end + 1)
    lost = steps + EARLY * np.minimum(steps, t90)
    flown = [as_arrays(each, reach, lost) for each in recording.choices.values() if len(each) > 1]
    return TrainingFlight(flown, (t90 / nominal, end / nominal) if team == 1 else (math.nan, math.nan))


def _covered(world: World, loaded: Loaded) -> float:
    """Return the team's coverage, or the one that its map claims where that can be wrong.

    So a flight ends when all has been seen, and what is seen again because of errors is not learned from. A network
    that closes loops is to show it rightly.
    """
    corrects = loaded.options and world.scenario.drift.rate > 0.0
    uncertain = world.scenario.uncertain and not corrects
    return world.claimed_coverage(0) if uncertain else float(world.team_coverage[0])


def _reported(world: World, policy: Recorder, late_cost: float) -> TrainingFlight:
    """Return a flight whose costs are the points that its home base lacks, see ``dddqn-reports``."""
    coverage, scenario = flown_coverage(world, policy), world.scenario
    total, reach = int(world.state.total[0]), scenario.lidar.range
    lost = points_lost_until(coverage[:, 0], late_cost) * POINT * reach
    flown = []
    for choices in policy.recording.choices.values():
        if len(choices) > 1:
            known, steps = np.array([(choice.known, choice.step) for choice in choices]).T
            true = true_state(coverage, steps, known, total, scenario.team, reach)
            flown.append(as_arrays(choices, reach, lost, 1.0, true))
    return TrainingFlight(flown, (math.nan, math.nan))


def as_arrays(
    choices: Sequence[Choice],
    lidar_range: float,
    lost: NDArray[np.float64],
    discount: float = DISCOUNT,
    true: NDArray[np.float32] | None = None,
) -> dict[str, NDArray[Any]]:
    """Return the C choices of one UAV as arrays by name, padded to K = ``MOST`` places.

    ``places`` (C, K, PLACE) and ``common`` (C, COMMON) are the network's inputs, ``there`` (C, K) bool whether there
    is such a place, ``costs`` (C, K) the planner's. ``true_places`` (C, K, TRUE_PLACE) and ``true_common`` (C,
    TRUE_COMMON) are those of the true map. ``probabilities`` (C, K) are those of the draw, ``chosen`` (C,) the rows.
    ``rewards`` (C,) are the negative costs until the next choice, ``durations`` (C,) the time until then, both in lidar
    ranges. ``discounts`` (C,) are the factors on what comes a lidar range later. With O options ``there`` and
    ``probabilities`` are (C, K + O), and ``true_common`` has the true state of the base behind that of the map.

    Args:
        choices: The choices.
        lidar_range: The lidar's range in cells.
        lost: (T + 1,) what each step until the end of the flight has cost, in steps.
        discount: The factor on what comes a lidar range later.
        true: (C, TRUE) the true state of a task with a base; None: zeros.

    """
    scenes, truths = [choice.scene for choice in choices], [choice.truth for choice in choices]
    steps = np.array([choice.step for choice in choices] + [len(lost) - 1])
    true_common = np.stack([each.common for each in truths])
    options = len(scenes[0].rules)
    if options:
        true = np.zeros((len(choices), TRUE), np.float32) if true is None else true
        true_common = np.concatenate([true_common, true], axis=1)
    counts = np.array([len(scene.cells) for scene in scenes])
    chosen = np.array([choice.chosen for choice in choices])
    there = [np.concatenate([np.ones(len(scene.cells), np.bool_), np.isfinite(scene.rules)]) for scene in scenes]
    return {
        "places": _padded([scene.places for scene in scenes]).astype(np.float16),
        "common": np.stack([scene.common for scene in scenes]),
        "there": _padded(there, options),
        "costs": _padded([scene.costs for scene in scenes]),
        "true_places": _padded([each.places for each in truths]).astype(np.float16),
        "true_common": true_common,
        "probabilities": _padded([choice.probabilities for choice in choices], options),
        "chosen": np.where(chosen < counts, chosen, chosen + MOST - counts),
        "rewards": (-np.diff(lost[steps]) / lidar_range).astype(np.float32),
        "durations": (np.diff(steps) / lidar_range).astype(np.float32),
        "discounts": np.full(len(choices), discount, np.float32),
    }


def _padded(rows: Sequence[NDArray[Any]], options: int = 0) -> NDArray[Any]:
    """Return C arrays (K' + O, ...) of up to ``MOST`` places as one (C, MOST + O, ...), with zeros behind the places.

    ``options`` is O.
    """
    out = np.zeros((len(rows), MOST + options, *rows[0].shape[1:]), rows[0].dtype)
    for k, row in enumerate(rows):
        count = len(row) - options
        out[k, :count], out[k, MOST:] = row[:count], row[count:]
    return out
