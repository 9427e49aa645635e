"""Every policy that this project registers, now or later: it explores everything, wastes no steps, and plays fair.

Any two settings are flown together here, by some policies in `make test` and by all in `make test-all`; `make soak`
flies all combinations.
"""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, Scenario, make_policy
from indoor_explorers.env.conformance import CHECKS, FAILURE_MODES
from indoor_explorers.env.maps.sources import FileMaps
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from tests.behaviour.episodes import LOST_UAV, MOST_DITHER, Case, FailureCase, longest_dither, violations
from tests.behaviour.policies import ALIKE, EXPLORERS, POLICIES, UNRELIABLE, parametrized, with_rows
from tests.behaviour.worlds import RADIOS, covering_array, small_maps
from tests.env.conformance.policies import MOST_CHECKS, passed_checks
from tests.marks import slow
from tests.planners import flights

ROWS = covering_array()
REAL_MAP = Path(__file__).resolve().parents[3] / "shared" / "maps" / "slam" / "Sarmis2_map_adj.yaml"
every_explorer = parametrized(EXPLORERS, slow=ALIKE)
#: Policies whose decisions take longest, and those that decide much as another one does.
SLOW_CONFORMANCE = (
    *("rrt-aep", "rrt-frontier", "rrt-nbv", "horizon", "frontier-predictive", "tours", "dddqn-places"),
    *("attention-sac", "pomdp", "pso", "bat", "aco", "sgba", "frontier-burgard", "pso-robots", *ALIKE),
)
#: Those that fly the failure modes apart, as only `make test-all` flies them through the conformance suite; those whose
#: decisions take longest, and others with other radios, fly them there, too.
FAILURE_MODES_APART = ("tours", "dddqn-places", "bat")
#: The policies that fly the office and a real map in `make test` and `make test-long`: one of each family; `make
#: test-all` flies the others.
OFFICE = ("frontier-nearest", "frontier-predictive", "pso", "dddqn")
some_explorers = parametrized(EXPLORERS, slow=[name for name in EXPLORERS if name not in OFFICE])


def flown(name: str, scenario: Scenario, seeds: Sequence[int]) -> list[Record]:
    return list(fly(make_policy(name), name, scenario, [Task(scenario.name, 0, seed) for seed in seeds]))


def assert_well_flown(records: Sequence[Record]) -> None:
    for record in records:
        assert record.outcome is Outcome.COMPLETE, record.task
        assert longest_dither(record) <= MOST_DITHER, record.task
        assert record.metrics["collisions"] == 0


@parametrized(POLICIES, slow=SLOW_CONFORMANCE)
def test_it_passes_the_conformance_suite(name):
    policy = make_policy(name)
    found = passed_checks(policy, MOST_CHECKS if name in UNRELIABLE else CHECKS)
    assert found["no hidden knowledge"].endswith("knows the true map" if policy.privileged else "changed nothing")
    assert name in UNRELIABLE or found["failure modes"].startswith("all 9 finished")


@with_rows(EXPLORERS, ROWS, slow=["pomdp", *ALIKE])
def test_it_explores_all_with_any_team_radio_and_lidar(name: str, row: dict[str, Any], map_files: Path) -> None:
    settings = {
        **RADIOS[row["radio"]],
        "lidar.range": row["lidar"],
        "spawn": "clustered" if row["team"] == 4 else "random",
    }
    case = Case.on(row["world"], map_files, name, row["team"], settings, seed=1)
    record = case.fly()
    assert violations(record) == [], case.command()
    assert longest_dither(record) <= MOST_DITHER, case.command()


@every_explorer
@pytest.mark.parametrize("world", ["room", *slow("corridors", "plus")])
def test_the_others_go_on_without_a_lost_uav(name: str, world: str, map_files: Path) -> None:
    settings = {**RADIOS["disc"], "spawn": "clustered", "on_collision": "end"}
    case = Case.on(world, map_files, f"{LOST_UAV}:{name}", 3, settings, seed=4)
    assert violations(case.fly()) == [], case.command()


@parametrized(EXPLORERS, slow=[name for name in EXPLORERS if name not in FAILURE_MODES_APART])
@pytest.mark.parametrize("radio", ["none", *slow("disc")])
def test_it_finishes_the_failure_modes_that_users_report(name: str, radio: str) -> None:
    cases = [FailureCase(name, mode.name, radio, seed=12) for mode in FAILURE_MODES]
    assert {case.command(): case.problems() for case in cases} == {case.command(): [] for case in cases}


@every_explorer
@pytest.mark.parametrize("radio", ["none", "disc", *slow("square", "unlimited")])
def test_two_lost_uavs_stall_nobody(name: str, radio: str) -> None:
    kind, reach = RADIOS[radio]["radio.model"], float(RADIOS[radio].get("radio.range", 0))
    free = flights.maze(5, 5, 4)
    flight = flights.fly(make_policy(name), free, team=3, radio=(kind, reach), ends={0: 4, 2: 9}, budget=1500)
    assert flight.complete
    assert flight.longest_dither <= MOST_DITHER


@every_explorer
@pytest.mark.parametrize("seed", [500, *slow(501)])
def test_a_team_of_four_completes_the_thesis_rooms(name: str, seed: int) -> None:
    assert_well_flown(flown(name, PRESETS["thesis-team-4"].for_evaluation(), [seed]))


@some_explorers
def test_it_completes_the_office(name: str) -> None:
    assert_well_flown(flown(name, PRESETS["office"].for_evaluation(), [8]))


@some_explorers
@pytest.mark.skipif(not REAL_MAP.exists(), reason="the development maps (../shared/maps) are not here")
@pytest.mark.parametrize("team", [*slow(1), 3])
def test_it_completes_a_real_map(name: str, team: int) -> None:
    scenario = Scenario(
        name="flat",
        map=FileMaps(paths=(str(REAL_MAP),), resolution=0.25),
        team=team,
        spawn="clustered",
        lidar={"range": 10.0},
        radio={"model": "disc", "range": 15.0},
        on_collision="block",
    ).for_evaluation()
    assert_well_flown(flown(name, scenario, [3]))


@every_explorer
def test_it_completes_the_smallest_maps(name: str) -> None:
    for shape in ((1, 1), (1, 12), (12, 1), (2, 2)):
        assert flights.fly(make_policy(name), np.ones(shape, np.bool_), lidar=1.0, budget=60).complete, shape


@every_explorer
def test_it_flies_the_same_again_and_as_a_pickled_copy(name: str) -> None:
    policy, free = make_policy(name), flights.rooms(2, 4, 3)
    first, second = (
        flights.fly(copy, free, team=3, radio=("disc", 6.0), seed=5)
        for copy in (policy, pickle.loads(pickle.dumps(policy)))
    )
    assert first.actions == second.actions


@every_explorer
def test_with_nothing_left_to_explore_it_stays(name: str) -> None:
    free = np.zeros((3, 9), np.bool_)
    free[1, :4] = free[1, 5:] = True
    flight = flights.fly(make_policy(name), free, team=2, spawns=[(1, 0), (1, 8)], budget=40, goal_of="agent")
    assert [row[0] for row in flight.actions[10:]] == [4] * 30


@every_explorer
@pytest.mark.parametrize("seed", [0, *slow(1, 2)])
def test_two_that_meet_in_a_corridor_pass_each_other(name: str, seed: int) -> None:
    free = np.zeros((7, 30), np.bool_)
    free[1:6, :5] = free[1:6, 25:] = free[3] = True
    spawns = [(3, 12), (3, 17)]
    flight = flights.fly(make_policy(name), free, team=2, seed=seed, spawns=spawns, goal_of="agent", lidar=1.0)
    assert (flight.world.state.end == 1).all()
    assert flight.steps < 800


@every_explorer
def test_without_radio_all_of_a_team_explore_a_maze(name: str) -> None:
    flight = flights.fly(make_policy(name), flights.maze(4, 5, 2), team=3, goal_of="agent", budget=4000)
    assert (flight.world.state.end == 1).all()


@lru_cache
def area_by_chance(seeds: range) -> float:
    return area(in_rooms("random", seeds))


@lru_cache
def steps_by_chance(world: str) -> int:
    return flights.fly(make_policy("random"), small_maps()[world], budget=4000).steps


def in_rooms(name: str, seeds: range) -> list[Record]:
    return flown(name, PRESETS["thesis-obstacles"].for_evaluation(), seeds)


def area(records: Sequence[Record]) -> float:
    """Mean area under the coverage curve."""
    return float(np.mean([record.metrics["auc"] for record in records]))


@every_explorer
@pytest.mark.parametrize("seeds", [range(900, 903), *slow(range(900, 905))], ids=len)
def test_alone_it_completes_the_thesis_rooms_and_beats_chance(name: str, seeds: range) -> None:
    records = in_rooms(name, seeds)
    assert_well_flown(records)
    assert area(records) > area_by_chance(seeds) + 0.1


@every_explorer
def test_it_is_faster_than_the_random_walk_on_every_kind_of_map(name: str) -> None:
    for world in ("small-maze", "small-rooms", "noise", "open"):
        assert flights.fly(make_policy(name), small_maps()[world]).steps < steps_by_chance(world), world


def test_the_random_walk_takes_every_legal_move() -> None:
    flight = flights.fly(make_policy("random"), np.ones((5, 5), np.bool_), budget=200, lidar=1.0)
    assert {action for (action,) in flight.actions} <= {0, 1, 2, 3}
    assert flights.fly(make_policy("random"), np.ones((1, 1), np.bool_), budget=3).complete
